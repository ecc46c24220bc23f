// Counts of solutions, compiled once for each instruction set.
#include "counting.hpp"

#include "border_basis.hpp"
#include "minimal_polynomial.hpp"
#include "motion_ring.hpp"
#include "residues.hpp"

namespace gsp {
namespace {

template <class F>
CountingResult count(const CountingProblem& problem) {
  const F field(problem.prime);
  Budget budget(problem.max_work, problem.max_entries, problem.check);
  CountingResult result{CountingOutcome::kFinite, 0, 0, 0, true, 0};
  MotionRing<F> ring(field, problem);
  if (ring.is_inconsistent()) {
    result.falls = 1;
    return result;
  }
  Elimination* const elimination = problem.elimination;
  BorderBasis<F> basis(field, ring.variables(), ring.generators(elimination), problem.seed, budget,
                       elimination == nullptr ? nullptr : &elimination->steps);
  result.distinct = -1;
  try {
    if (basis.compute()) {
      result.solutions = basis.dimension();
    } else {
      result.outcome = CountingOutcome::kInfinite;
    }
  } catch (const WorkLimit&) {
    result.outcome = CountingOutcome::kStopped;
  }
  result.falls = basis.falls();
  result.all_commutators = basis.all_commutators();
  if (result.outcome == CountingOutcome::kFinite && problem.find_distinct) {
    try {
      result.distinct = count_values(field, basis, ring.variables(), budget);
    } catch (const WorkLimit&) {
      result.distinct = -1;
    }
  }
  result.work = budget.work();
  return result;
}

}  // namespace

CountingResult GSP_COUNT(const CountingProblem& problem) {
  return problem.prime >> 31 == 0 ? count<Residues31>(problem) : count<Residues61>(problem);
}

}  // namespace gsp
