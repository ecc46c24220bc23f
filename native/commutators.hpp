// Border bases: commutators of two variables on the normal monomials, and a test whether there are enough.
//
// Part of border_basis.hpp, which includes it.
#pragma once

#include "border_basis.hpp"

namespace gsp {
namespace {

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
