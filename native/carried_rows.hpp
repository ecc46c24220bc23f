// Border bases: rows that were reduced before a fall of degree and are used again after it.
//
// Part of border_basis.hpp, which includes it.
#pragma once

#include "border_basis.hpp"

namespace gsp {
namespace {

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

}  // namespace
}  // namespace gsp
