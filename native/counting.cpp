// Counts of solutions, compiled once for each instruction set.

#include "counting.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "border_basis.hpp"
#include "motion_ring.hpp"
#include "residues.hpp"

namespace gsp {
namespace {

// The finite algebra of the solutions: minimal polynomials of linear forms, and where they vanish.

// The shortest recurrence of a sequence (Berlekamp and Massey), constant term of the recurrence
// first: sum of c_j s_(i - j) = 0 with c_0 = 1.
template <class F>
std::vector<typename F::Residue> shortest_recurrence(
    const F& field, const std::vector<typename F::Residue>& s) {
  using Residue = typename F::Residue;
  std::vector<Residue> c{1}, b{1};
  Residue discrepancy = 1;
  int length = 0, shift = 1;
  for (int i = 0; i < static_cast<int>(s.size()); ++i) {
    Residue delta = s[i];
    for (int j = 1; j <= length; ++j)
      if (j < static_cast<int>(c.size())) delta = field.add(delta, field.multiply(c[j], s[i - j]));
    if (delta == 0) {
      ++shift;
      continue;
    }
    const std::vector<Residue> kept = c;
    const Residue factor = field.multiply(delta, field.inverse(discrepancy));
    c.resize(std::max(c.size(), b.size() + shift), 0);
    for (std::size_t j = 0; j < b.size(); ++j)
      c[j + shift] = field.subtract(c[j + shift], field.multiply(factor, b[j]));
    if (2 * length <= i) {
      length = i + 1 - length;
      b = kept;
      discrepancy = delta;
      shift = 1;
    } else {
      ++shift;
    }
  }
  c.resize(length + 1, 0);
  return c;
}

// The degree of the greatest common divisor of a polynomial, highest coefficient first, and its
// derivative.
template <class F>
int degree_of_repeated_factors(const F& field, const std::vector<typename F::Residue>& f) {
  using Residue = typename F::Residue;
  std::vector<Residue> a(f), b;
  const std::size_t degree = f.size() - 1;
  for (std::size_t k = 0; k < degree; ++k)
    b.push_back(field.multiply(f[k], static_cast<Residue>(degree - k)));
  const auto trim = [](std::vector<Residue>& x) {
    x.erase(x.begin(), std::find_if(x.begin(), x.end(), [](Residue c) { return c != 0; }));
  };
  trim(b);
  while (!b.empty()) {
    const Residue inverse = field.inverse(b.front());
    while (a.size() >= b.size()) {
      const Residue factor = field.multiply(a.front(), inverse);
      for (std::size_t k = 0; k < b.size(); ++k)
        a[k] = field.subtract(a[k], field.multiply(factor, b[k]));
      a.erase(a.begin());
    }
    trim(a);
    std::swap(a, b);
  }
  return static_cast<int>(a.size()) - 1;
}

// The algebra of the solutions: a vector space over the normal monomials, in their order.
template <class F>
class SolutionAlgebra {
 public:
  using Residue = typename F::Residue;
  using Vector = std::vector<Residue>;
  using Matrix = std::vector<Vector>;

  SolutionAlgebra(const F& field, BorderBasis<F>& basis, int variables, Budget& budget)
      : field_(field), basis_(basis), variables_(variables), budget_(budget) {}

  // How many values a random linear form takes on the solutions: no more than there are distinct
  // ones, and as many unless a random choice was unlucky. Of many solutions first those of a
  // variable, whose matrix is sparse: if it tells all solutions apart, that is the number.
  int count_values() {
    if (size() == 0) return 0;
    Vector one(size(), 0);
    one[0] = 1;
    if (size() >= kMany && count_values(one, multiplication(sparsest_variable())) == size())
      return size();
    return count_values(one, multiplication(random_form()));
  }

  // An element of the algebra: an affine form plus weighted squares of affine forms; the constant
  // of a form is its last entry.
  struct Element {
    Vector form;
    std::vector<std::pair<Residue, Vector>> squares;
  };

  // How many solutions there are, and how many values a form takes on them, where none of some
  // elements vanishes; on all of them it takes `distinct`.
  std::pair<int, int> count_where_not_zero(const std::vector<Element>& elements, int distinct) {
    Matrix space;
    for (int k = 0; k < size(); ++k) {
      space.emplace_back(size(), 0);
      space.back()[k] = 1;
    }
    for (const Element& element : elements) {
      const Matrix matrix = multiplication(element);
      // The images under powers shrink to the part where the element is a unit.
      for (std::size_t before = size() + 1; !space.empty() && space.size() != before;) {
        before = space.size();
        space = image(space, matrix);
      }
    }
    if (space.empty()) return {0, 0};
    if (static_cast<int>(space.size()) == size()) return {size(), distinct};
    Accumulator<F> sums(field_, size());
    for (const Vector& row : space) sums.subtract_multiple(0, row.data(), basis_.random(), size());
    return {static_cast<int>(space.size()),
            count_values(taken(sums), multiplication(random_form()))};
  }

 private:
  static constexpr int kMany = 100;

  int size() const { return basis_.dimension(); }

  Vector random_form() {
    Vector form(variables_ + 1);
    for (Residue& x : form) x = basis_.random();
    return form;
  }
  // The variable whose products with normal monomials are most often normal.
  Vector sparsest_variable() {
    int best = 0, most = -1;
    for (int i = 0; i < variables_; ++i) {
      int normal = 0;
      for (int k = 0; k < size(); ++k) normal += basis_.position_of_product(k, i) >= 0;
      if (normal > most) best = i, most = normal;
    }
    Vector form(variables_ + 1, 0);
    form[best] = 1;
    return form;
  }
  Vector taken(Accumulator<F>& sums) const {
    sums.flush();
    Vector row(size());
    for (int k = 0; k < size(); ++k) row[k] = sums.at(k);
    return row;
  }
  // The products of an affine form and the normal monomials.
  Matrix multiplication(const Vector& form) {
    budget_.keep(static_cast<std::uint64_t>(size()) * size());
    Matrix rows;
    Accumulator<F> sums(field_, size());
    for (int k = 0; k < size(); ++k) {
      sums.clear();
      sums.set(k, form[variables_]);
      for (int i = 0; i < variables_; ++i) {
        if (form[i] == 0) continue;
        const Vector image = basis_.image(k, i);
        sums.subtract_multiple(0, image.data(), field_.negative(form[i]), size());
      }
      budget_.spend(static_cast<std::uint64_t>(variables_) * size());
      rows.push_back(taken(sums));
    }
    return rows;
  }
  Matrix multiplication(const Element& element) {
    Matrix result = multiplication(element.form);
    for (const auto& [weight, form] : element.squares) {
      const Matrix once = multiplication(form);
      for (int k = 0; k < size(); ++k) {
        const Vector twice = product(once[k], once);
        for (int j = 0; j < size(); ++j)
          result[k][j] = field_.add(result[k][j], field_.multiply(weight, twice[j]));
      }
    }
    return result;
  }
  Vector product(const Vector& vector, const Matrix& matrix) {
    return product(vector, matrix, std::vector<int>(size(), -1));
  }
  // The same for a matrix some of whose rows have a one and nothing else: where, or -1.
  Vector product(const Vector& vector, const Matrix& matrix, const std::vector<int>& ones) {
    Accumulator<F> sums(field_, size());
    std::uint64_t work = size();
    for (int k = 0; k < size(); ++k) {
      if (vector[k] == 0) continue;
      if (ones[k] >= 0) {
        sums.add(ones[k], vector[k]);
      } else {
        sums.subtract_later(0, matrix[k].data(), field_.negative(vector[k]), size());
        work += size();
      }
    }
    budget_.spend(work);
    return taken(sums);
  }
  // Of each row where it has a one and nothing else, or -1.
  std::vector<int> ones(const Matrix& matrix) const {
    std::vector<int> result;
    for (const Vector& row : matrix) {
      const auto is_zero = [](Residue x) { return x == 0; };
      const auto first = std::find_if_not(row.begin(), row.end(), is_zero);
      const bool is_one = first != row.end() && *first == 1 &&
                          std::all_of(first + 1, row.end(), is_zero);
      result.push_back(is_one ? static_cast<int>(first - row.begin()) : -1);
    }
    return result;
  }
  // A basis of the images of some vectors.
  Matrix image(const Matrix& vectors, const Matrix& matrix) {
    Echelon<F> echelon(field_, size());
    Matrix result;
    for (const Vector& vector : vectors) {
      const Vector row = product(vector, matrix);
      echelon.accumulator.clear();
      for (int k = 0; k < size(); ++k) echelon.accumulator.set(k, row[k]);
      const std::uint64_t before = echelon.work();
      if (echelon.push()) result.push_back(row);
      budget_.spend(echelon.work() - before);
    }
    return result;
  }
  // How many values a form takes on the solutions where an element does not vanish.
  int count_values(Vector vector, const Matrix& matrix) {
    const std::vector<int> sparse = ones(matrix);
    Vector weights(size()), sequence;
    for (Residue& x : weights) x = basis_.random();
    for (int step = 0; step < 2 * size(); ++step) {
      Residue value = 0;
      for (int k = 0; k < size(); ++k)
        value = field_.add(value, field_.multiply(vector[k], weights[k]));
      sequence.push_back(value);
      vector = product(vector, matrix, sparse);
    }
    const Vector polynomial = shortest_recurrence(field_, sequence);
    return static_cast<int>(polynomial.size()) - 1 -
           degree_of_repeated_factors(field_, polynomial);
  }

  const F& field_;
  BorderBasis<F>& basis_;
  int variables_;
  Budget& budget_;
};

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
