// Border bases modulo a prime: the normal monomials of an ideal and how variables multiply them.
//
// Works degree by degree, after B. Mourrain, "A new criterion for normal form algorithms", AAECC
// 1999. The products of the normal monomials of degree d - 1 and the variables are reduced. They
// are reduced by the generators of degree d and by the commutators x_i (x_j u) = x_j (x_i u), u
// normal of degree d - 2. A relation whose top form vanishes (a fall of degree) becomes a generator
// of its degree, and the work continues from that degree. Rows that were reduced before are kept.
// The normal monomials are those of the degree reverse lexicographic order.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "budget.hpp"
#include "echelon.hpp"
#include "monomials.hpp"
#include "motion_ring.hpp"

namespace gsp {
namespace {

// Normal monomials and the normal forms of the monomials at their border, as far as they are known.

template <class F>
class NormalForms {
 public:
  using Residue = typename F::Residue;
  // A vector over the normal monomials up to some degree, the last one first.
  using Vector = std::vector<Residue>;

  int dimension() const { return static_cast<int>(normal_.size()); }
  // A variable times a normal monomial, over the normal monomials in their order.
  Vector image(int k, int i) {
    Vector result = product(normal_[k], i);
    std::reverse(result.begin(), result.end());
    result.resize(dimension(), 0);
    return result;
  }
  // The position of a variable times a normal monomial among the normal ones, or -1.
  int position_of_product(int k, int i) { return position_[times(normal_[k], i)]; }

 protected:
  NormalForms(const F& field, int variables, Budget& budget)
      : field_(field), variables_(variables), budget_(budget), monomials_(variables) {}

  void grow() {
    if (position_.size() < static_cast<std::size_t>(monomials_.size())) {
      position_.resize(monomials_.size(), -1);
      form_.resize(monomials_.size());
    }
  }
  int times(int k, int i) {
    const int result = monomials_.times(k, i);
    grow();
    return result;
  }
  bool is_normal(int k) const { return position_[k] >= 0; }
  Vector unit(int position) const {
    Vector result(position + 1, 0);
    result[0] = 1;
    return result;
  }
  const Vector& known(int k) {
    if (is_normal(k) && form_[k].empty()) {
      form_[k] = unit(position_[k]);
      budget_.keep(form_[k].size());
    }
    return form_[k];
  }
  const Vector& product(int k, int i) { return known(times(k, i)); }
  // The normal form of a monomial below the present degree.
  Vector normal_form(Monomial m, int degree) {
    const int k = monomials_.find(m);
    if (k >= 0 && (is_normal(k) || !form_[k].empty())) return known(k);
    const int i = divisor(m);
    const Vector rest = normal_form(m - variable(i), degree - 1);
    Accumulator<F> sums(field_, dimension());
    add_multiple(sums, rest, i, 1, degree, 0);
    Vector result(dimension());
    for (int t = 0; t < dimension(); ++t) result[t] = sums.at(t);
    return result;
  }
  // A variable that divides a monomial, such that the rest is known, if there is one.
  int divisor(Monomial m) {
    int any = -1;
    for (int i = 0; i < variables_; ++i) {
      if (exponent(m, i) == 0) continue;
      const int k = monomials_.find(m - variable(i));
      if (k >= 0 && (is_normal(k) || !form_[k].empty())) return i;
      any = i;
    }
    return any;
  }
  // Adds a multiple of a variable times a vector. Columns: those of degree d, then the normal
  // monomials, the last one first.
  void add_multiple(Accumulator<F>& sums, const Vector& vector, int i, Residue factor, int d,
                    int top) {
    const int length = static_cast<int>(vector.size());
    for (int t = 0; t < length; ++t) {
      if (vector[t] == 0) continue;
      const Residue value = factor == 1 ? vector[t] : field_.multiply(vector[t], factor);
      add_known(sums, times(normal_[length - 1 - t], i), value, d, top);
    }
    sums.flush();
  }
  void add_known(Accumulator<F>& sums, int k, Residue value, int d, int top) {
    if (top > 0 && monomials_.degree(k) == d) {
      sums.add(column_[k], value);
    } else if (is_normal(k)) {
      sums.add(top + dimension() - 1 - position_[k], value);
    } else {
      const Vector& form = form_[k];
      const int length = static_cast<int>(form.size());
      sums.subtract_later(top + dimension() - length, form.data(), field_.negative(value), length);
      spent_ += length;
    }
  }

  const F& field_;
  int variables_;
  Budget& budget_;
  Monomials monomials_;
  std::vector<int> position_;  // of each monomial among the normal ones, or -1
  std::vector<Vector> form_;   // of each border monomial its normal form
  std::vector<int> normal_;    // the normal monomials, degree by degree
  std::vector<int> start_;     // of each degree the position of its first
  std::vector<int> column_;    // of each monomial of the present degree
  std::uint64_t spent_ = 0;    // multiplications not yet charged
};

template <class F>
class BorderBasis : public NormalForms<F> {
 public:
  using Base = NormalForms<F>;
  using typename Base::Residue;
  using typename Base::Vector;
  using Base::dimension;

  BorderBasis(const F& field, int variables, std::vector<Polynomial<F>> generators,
              std::uint64_t seed, Budget& budget, std::vector<EliminationStep>* trace = nullptr)
      : Base(field, variables, budget),
        generators_(std::move(generators)),
        random_(seed),
        trace_(trace) {}

  // Finds the basis; returns false if the solutions are not finite in number.
  bool compute();

  int falls() const { return falls_; }
  bool all_commutators() const { return all_commutators_; }
  // The degree of the products of generators and monomials of which all relations are sums.
  int reach() const { return reach_; }
  Residue random() { return static_cast<Residue>(random_() % field_.prime); }

 private:
  using Base::add_known, Base::add_multiple, Base::divisor, Base::is_normal, Base::known;
  using Base::normal_form, Base::product, Base::times;
  using Base::budget_, Base::column_, Base::field_, Base::form_, Base::monomials_, Base::normal_;
  using Base::position_, Base::spent_, Base::start_, Base::variables_;

  struct Commutator {
    int monomial, i, j;
  };
  // A reduced row of an earlier step, by the numbers of its monomials.
  struct Carried {
    int step, row;
    std::vector<std::pair<int, Residue>> terms;
  };

  // Makes room for what is kept of each monomial.
  void make_room() {
    origin_.resize(monomials_.size());
    was_normal_.resize(monomials_.size(), 0);
    is_fresh_.resize(monomials_.size(), 0);
  }
  std::vector<int> columns_of(int d);
  void add_generators(Echelon<F>& matrix, int d);
  void add_carried(Echelon<F>& matrix, int d);
  void add_commutators(Echelon<F>& matrix, int d);
  void add_term(Accumulator<F>& sums, Monomial m, int degree, Residue value, int d);
  bool is_carried(int d) const {
    return d < static_cast<int>(carried_.size()) && !carried_[d].empty();
  }
  void carry(const Echelon<F>& matrix, const std::vector<int>& columns, int from, int d);
  void spend(const Echelon<F>& matrix) {
    budget_.spend(matrix.work() - std::exchange(seen_work_, matrix.work()) + matrix.columns() +
                  std::exchange(spent_, 0));
  }
  template <class Source>
  bool push(Echelon<F>& matrix, const Source& source) {
    const bool grown = matrix.push();
    spend(matrix);
    if (grown && trace_ != nullptr) {
      trace_->back().sources.push_back(source());
      trace_->back().pivots.push_back(matrix.pivot(matrix.rank() - 1));
    }
    return grown;
  }
  bool push_commutator(Echelon<F>& matrix, const Commutator& row, int d) {
    matrix.accumulator.clear();
    add_multiple(matrix.accumulator, product(row.monomial, row.i), row.j, 1, d, top_);
    add_multiple(matrix.accumulator, product(row.monomial, row.j), row.i, field_.negative(1), d,
                 top_);
    return push(matrix, [&] {
      std::vector<int> source{row.i, row.j};
      for (int i = 0; i < variables_; ++i)
        source.push_back(exponent(monomials_[row.monomial], i));
      return source;
    });
  }
  bool has_new_commutator(Echelon<F>& matrix, int d);
  Vector times_form(const Vector& form, const Vector& vector, int d);
  bool take_falls(const Echelon<F>& matrix, int& d);
  void commit(const Echelon<F>& matrix, const std::vector<int>& columns, int d);
  void forget_from(int d);
  bool is_positive(int d) const;

  static constexpr int kRowsBetweenTrials = 16, kStreak = 8;
  static constexpr int kTests = sizeof(Residue) == 8 ? 1 : 3;  // small primes need more

  std::vector<Polynomial<F>> generators_;
  std::mt19937_64 random_;
  std::vector<EliminationStep>* trace_;
  std::vector<int> hilbert_;                       // normal monomials of each degree
  std::vector<std::pair<Monomial, int>> leading_;  // minimal leading monomials, their degrees
  std::vector<std::pair<int, int>> origin_;        // of each normal form the step and its row
  std::vector<std::vector<Carried>> carried_;      // by degree
  std::vector<char> was_normal_;  // whether a monomial was normal before the last fall
  std::vector<char> is_fresh_;    // whether it leads since then
  int steps_ = 0;
  int top_ = 0;  // columns of the present degree
  int falls_ = 0;
  // By how much the products may exceed the relations made of them.
  int excess_ = 0;
  int reach_ = 0;
  bool all_commutators_ = true;
  std::uint64_t seen_work_ = 0;
};

template <class F>
bool BorderBasis<F>::compute() {
  Base::grow();
  for (const Polynomial<F>& generator : generators_) {
    if (generator.degree < 2) {  // it was a quadric
      ++falls_;
      excess_ = std::max(excess_, 2 - generator.degree);
    }
    if (generator.degree == 0) return true;  // no solution
  }
  normal_ = {0};
  position_[0] = 0;
  start_ = {0};
  hilbert_ = {1};
  for (int d = 1;; ++d) {
    if (d > kMaxDegree - 1) throw WorkLimit();
    const std::vector<int> columns = columns_of(d);
    Echelon<F> matrix(field_, top_ + dimension());
    seen_work_ = 0;
    if (trace_ != nullptr) trace_->push_back({d, {}, {}});
    ++steps_;
    add_generators(matrix, d);
    add_carried(matrix, d);
    if (d >= 2) add_commutators(matrix, d);
    matrix.back_substitute();
    spend(matrix);
    const int present = d;
    reach_ = std::max(reach_, d + excess_);
    if (take_falls(matrix, d)) {
      excess_ += present - d;
      if (d > 0) carry(matrix, columns, d, present);
      if (d == 0) {
        forget_from(0);
        return true;  // no solution
      }
      forget_from(d);
      --d;
      continue;
    }
    commit(matrix, columns, d);
    int last = static_cast<int>(hilbert_.size()) - 1;
    while (last > 0 && hilbert_[last] == 0) --last;
    if (d >= last + 2) return true;
    if (is_positive(d)) return false;
  }
}

// Numbers the columns: the products of normal monomials of degree d - 1 and the variables.
template <class F>
std::vector<int> BorderBasis<F>::columns_of(int d) {
  std::vector<int> columns;
  for (int k = start_[d - 1]; k < dimension(); ++k)
    for (int i = 0; i < variables_; ++i) columns.push_back(times(normal_[k], i));
  std::sort(columns.begin(), columns.end());
  columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
  std::sort(columns.begin(), columns.end(),
            [&](int a, int b) { return monomials_.greater(a, b); });
  make_room();
  column_.assign(monomials_.size(), -1);
  top_ = static_cast<int>(columns.size());
  for (int c = 0; c < top_; ++c) column_[columns[c]] = c;
  return columns;
}

template <class F>
void BorderBasis<F>::add_generators(Echelon<F>& matrix, int d) {
  for (std::size_t g = 0; g < generators_.size(); ++g) {
    const Polynomial<F>& generator = generators_[g];
    if (generator.degree != d) continue;
    matrix.accumulator.clear();
    for (const auto& [m, value] : generator.terms) {
      int degree = 0;
      for (int i = 0; i < variables_; ++i) degree += exponent(m, i);
      add_term(matrix.accumulator, m, degree, value, d);
    }
    push(matrix, [&] { return std::vector<int>{static_cast<int>(g)}; });
  }
}

// Adds a multiple of any monomial up to degree d.
template <class F>
void BorderBasis<F>::add_term(Accumulator<F>& sums, Monomial m, int degree, Residue value, int d) {
  if (degree == 0) {
    sums.add(top_ + dimension() - 1, value);
    return;
  }
  const int i = divisor(m);
  add_multiple(sums, normal_form(m - variable(i), degree - 1), i, value, d, top_);
}

// Makes generators of the rows without a monomial of degree d; d becomes the least of their degrees.
template <class F>
bool BorderBasis<F>::take_falls(const Echelon<F>& matrix, int& d) {
  int least = d;
  for (int row = 0; row < matrix.rank(); ++row) {
    if (matrix.pivot(row) < top_) continue;
    Polynomial<F> generator;
    for (int c = matrix.pivot(row); c < matrix.columns(); ++c) {
      const Residue value = matrix.entry(row, c);
      if (value == 0) continue;
      const int k = normal_[top_ + dimension() - 1 - c];
      generator.terms.emplace_back(monomials_[k], value);
      generator.degree = std::max(generator.degree, monomials_.degree(k));
    }
    least = std::min(least, generator.degree);
    generators_.push_back(std::move(generator));
    ++falls_;
  }
  const bool any = least < d;
  d = least;
  return any;
}

template <class F>
void BorderBasis<F>::commit(const Echelon<F>& matrix, const std::vector<int>& columns, int d) {
  const int before = dimension();
  start_.push_back(before);
  std::vector<int> added;
  for (int c = top_ - 1; c >= 0; --c) {
    if (matrix.row_of(c) >= 0) continue;
    position_[columns[c]] = dimension();
    normal_.push_back(columns[c]);
    added.push_back(c);
  }
  hilbert_.push_back(static_cast<int>(added.size()));
  for (int c = 0; c < top_; ++c) {
    const int row = matrix.row_of(c);
    if (row < 0) continue;
    Vector form(dimension());
    const int fresh = static_cast<int>(added.size());
    for (int t = 0; t < fresh; ++t)
      form[fresh - 1 - t] = field_.negative(matrix.entry(row, added[t]));
    for (int t = 0; t < before; ++t) form[fresh + t] = field_.negative(matrix.entry(row, top_ + t));
    budget_.keep(form.size());
    form_[columns[c]] = std::move(form);
    origin_[columns[c]] = {steps_ - 1, row};
    is_fresh_[columns[c]] = was_normal_[columns[c]];
    const Monomial m = monomials_[columns[c]];
    bool minimal = true;
    for (int i = 0; i < variables_ && minimal; ++i) {
      if (exponent(m, i) == 0) continue;
      const int k = monomials_.find(m - variable(i));
      minimal = k >= 0 && is_normal(k);
    }
    if (minimal) leading_.emplace_back(m, d);
  }
}

template <class F>
void BorderBasis<F>::forget_from(int d) {
  for (int k = 0; k < monomials_.size(); ++k)
    if (monomials_.degree(k) >= d) {
      position_[k] = -1;
      if (k < static_cast<int>(form_.size())) {
        budget_.release(form_[k].size());
        form_[k] = Vector();
      }
    }
  if (static_cast<int>(start_.size()) > d) {
    normal_.resize(start_[d]);
    start_.resize(d);
    hilbert_.resize(d);
  }
  std::erase_if(leading_, [&](const auto& entry) { return entry.second >= d; });
}

// Whether all critical pairs are behind, and some variable has no power that leads.
template <class F>
bool BorderBasis<F>::is_positive(int d) const {
  int needed = 2;
  for (const Polynomial<F>& generator : generators_) needed = std::max(needed, generator.degree);
  for (std::size_t a = 0; a < leading_.size() && needed <= d; ++a)
    for (std::size_t b = a + 1; b < leading_.size(); ++b) {
      int degree = 0;
      bool coprime = true;
      for (int i = 0; i < variables_; ++i) {
        const int x = exponent(leading_[a].first, i), y = exponent(leading_[b].first, i);
        degree += std::max(x, y);
        coprime &= x == 0 || y == 0;
      }
      if (!coprime) needed = std::max(needed, degree);
    }
  if (needed > d) return false;
  for (int i = 0; i < variables_; ++i) {
    const bool pure = std::any_of(leading_.begin(), leading_.end(), [&](const auto& entry) {
      return entry.first == variable(i) * static_cast<unsigned>(entry.second);
    });
    if (!pure) return true;
  }
  return false;
}

// Border bases: rows that were reduced before a fall of degree and are used again after it.

template <class F>
void BorderBasis<F>::add_carried(Echelon<F>& matrix, int d) {
  if (!is_carried(d)) return;
  for (const Carried& carried : carried_[d]) {
    matrix.accumulator.clear();
    for (const auto& [k, value] : carried.terms) {
      const int degree = monomials_.degree(k);
      if (degree == d && k < static_cast<int>(column_.size()) && column_[k] >= 0) {
        matrix.accumulator.add(column_[k], value);
      } else if (degree < d && (is_normal(k) || !form_[k].empty())) {
        add_known(matrix.accumulator, k, value, d, top_);
      } else {
        add_term(matrix.accumulator, monomials_[k], degree, value, d);
      }
    }
    matrix.accumulator.flush();
    push(matrix, [&] { return std::vector<int>{-1, carried.step, carried.row}; });
  }
  budget_.spend(carried_[d].size());
}

// Keeps the reduced rows of the degrees that will be done again.
template <class F>
void BorderBasis<F>::carry(const Echelon<F>& matrix, const std::vector<int>& columns, int from,
                           int d) {
  if (static_cast<int>(carried_.size()) <= d) carried_.resize(d + 1);
  for (int degree = from; degree <= d; ++degree) carried_[degree].clear();
  std::fill(was_normal_.begin(), was_normal_.end(), 0);
  std::fill(is_fresh_.begin(), is_fresh_.end(), 0);
  for (const int k : normal_) was_normal_[k] = 1;
  for (int c = 0; c < top_; ++c) {
    const int row = matrix.row_of(c);
    if (row < 0) {
      was_normal_[columns[c]] = 1;
      continue;
    }
    Carried kept{steps_ - 1, row, {}};
    for (int other = c; other < matrix.columns(); ++other) {
      const Residue value = matrix.entry(row, other);
      if (value == 0) continue;
      kept.terms.emplace_back(
          other < top_ ? columns[other] : normal_[top_ + dimension() - 1 - other], value);
    }
    carried_[d].push_back(std::move(kept));
  }
  for (int k = 0; k < static_cast<int>(form_.size()); ++k) {
    const int degree = monomials_.degree(k);
    if (degree < from || degree >= d || is_normal(k) || form_[k].empty()) continue;
    Carried kept{origin_[k].first, origin_[k].second, {{k, 1}}};
    const int length = static_cast<int>(form_[k].size());
    for (int t = 0; t < length; ++t)
      if (form_[k][t] != 0)
        kept.terms.emplace_back(normal_[length - 1 - t], field_.negative(form_[k][t]));
    carried_[degree].push_back(std::move(kept));
  }
  // The least leading monomials first, so that tails are reduced when they are used.
  for (int degree = from; degree <= d; ++degree)
    std::sort(carried_[degree].begin(), carried_[degree].end(),
              [&](const Carried& a, const Carried& b) {
                return monomials_.greater(b.terms.front().first, a.terms.front().first);
              });
}

// Border bases: commutators of two variables on the normal monomials, and a test whether there are enough.

template <class F>
void BorderBasis<F>::add_commutators(Echelon<F>& matrix, int d) {
  // The first row of each column that is a multiple of an old leading monomial comes first, the
  // least columns first, so that its tail is reduced already.
  std::vector<std::pair<int, Commutator>> first;
  std::vector<Commutator> rest;
  std::vector<char> seen(top_, 0);
  for (int k = start_[d - 2]; k < start_[d - 1]; ++k)
    for (int i = 0; i < variables_; ++i)
      for (int j = i + 1; j < variables_; ++j) {
        const int a = times(normal_[k], i), b = times(normal_[k], j);
        if (is_normal(a) && is_normal(b)) continue;
        const int both = times(a, j);
        const int column =
            both < static_cast<int>(column_.size()) ? column_[both] : -1;
        const bool next_door = is_normal(a) || is_normal(b);
        if (next_door && column >= 0 && !seen[column]) {
          seen[column] = 1;
          first.push_back({column, {normal_[k], i, j}});
        } else {
          rest.push_back({normal_[k], i, j});
        }
      }
  std::sort(first.begin(), first.end(),
            [](const auto& a, const auto& b) { return a.first > b.first; });
  if (is_carried(d)) {
    // Old commutators lie in the span of the rows carried over; new ones come from monomials that
    // did not lead before.
    for (const auto& [column, row] : first) rest.push_back(row);
    const auto old = std::stable_partition(rest.begin(), rest.end(), [&](const Commutator& row) {
      return is_fresh_[times(row.monomial, row.i)] || is_fresh_[times(row.monomial, row.j)];
    });
    for (auto row = rest.begin(); row != old; ++row) push_commutator(matrix, *row, d);
    rest.erase(rest.begin(), old);
  } else {
    for (const auto& [column, row] : first) push_commutator(matrix, row, d);
  }
  std::shuffle(rest.begin(), rest.end(), random_);
  // Random combinations of all commutators show whether the remaining ones add nothing new.
  std::size_t next = 0;
  int streak = kStreak;
  while (next < rest.size()) {
    if (streak >= kStreak) {
      streak = 0;
      int tests = 0;
      while (tests < kTests && !has_new_commutator(matrix, d)) ++tests;
      if (tests == kTests) {
        all_commutators_ = false;
        return;
      }
    }
    for (int k = 0; k < kRowsBetweenTrials && next < rest.size(); ++k, ++next)
      streak = push_commutator(matrix, rest[next], d) ? 0 : streak + 1;
  }
}

template <class F>
typename BorderBasis<F>::Vector BorderBasis<F>::times_form(const Vector& form,
                                                            const Vector& vector, int d) {
  Accumulator<F> sums(field_, dimension());
  for (int i = 0; i < variables_; ++i) add_multiple(sums, vector, i, form[i], d, 0);
  Vector result(dimension());
  for (int t = 0; t < dimension(); ++t) result[t] = sums.at(t);
  return result;
}

// Whether a (b u) - b (a u), for random linear forms a, b and a random combination u, is new.
template <class F>
bool BorderBasis<F>::has_new_commutator(Echelon<F>& matrix, int d) {
  Vector a(variables_), b(variables_), u(start_[d - 1], 0);
  for (Residue& x : a) x = random();
  for (Residue& x : b) x = random();
  for (int t = 0; t < start_[d - 1] - start_[d - 2]; ++t) u[t] = random();
  const Vector au = times_form(a, u, d), bu = times_form(b, u, d);
  matrix.accumulator.clear();
  for (int i = 0; i < variables_; ++i) {
    add_multiple(matrix.accumulator, bu, i, a[i], d, top_);
    add_multiple(matrix.accumulator, au, i, field_.negative(b[i]), d, top_);
  }
  const bool is_new = matrix.reduce() >= 0;
  spend(matrix);
  return is_new;
}

}  // namespace
}  // namespace gsp
