// Counts of solutions, compiled once for each instruction set.
#include "counting.hpp"

#include <vector>

#include "border_basis.hpp"
#include "solution_algebra.hpp"
#include "motion_ring.hpp"
#include "residues.hpp"

namespace gsp {
namespace {

// A row of the problem as an element of the algebra of solutions.
template <class F>
typename SolutionAlgebra<F>::Element element(const MotionRing<F>& ring,
                                             const CountingProblem& problem, int row) {
  const int width = kFunctions + problem.moments;
  typename SolutionAlgebra<F>::Element result{ring.affine(problem.functions + row * width), {}};
  for (int s = 0; s < problem.squares; ++s)
    if (problem.owners[s] == row)
      result.squares.emplace_back(static_cast<typename F::Residue>(problem.weights[s]),
                                  ring.affine(problem.square_functions + s * width));
  return result;
}

template <class F>
CountingResult count(const CountingProblem& problem) {
  const F field(problem.prime);
  Budget budget(problem.max_work, problem.max_entries, problem.check);
  CountingResult result{CountingOutcome::kFinite, 0, 0, {}, {}, 0, 2, true, 0};
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
  result.reach = basis.reach();
  result.all_commutators = basis.all_commutators();
  if (result.outcome == CountingOutcome::kFinite && problem.find_distinct) {
    SolutionAlgebra<F> algebra(field, basis, ring.variables(), budget);
    try {
      result.distinct = algebra.count_values();
      for (const std::vector<int>& group : problem.groups) {
        std::vector<typename SolutionAlgebra<F>::Element> elements;
        for (const int row : group) elements.push_back(element<F>(ring, problem, row));
        const auto [apart, distinct] = algebra.count_where_not_zero(elements, result.distinct);
        result.apart.push_back(apart);
        result.apart_distinct.push_back(distinct);
      }
    } catch (const WorkLimit&) {
    }
  }
  result.work = budget.work();
  return result;
}

}  // namespace

CountingResult GSP_COUNT(const CountingProblem& problem) {
  return problem.prime >> 30 == 0 ? count<Residues30>(problem) : count<Residues61>(problem);
}

}  // namespace gsp
