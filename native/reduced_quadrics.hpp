// Six quadrics solved for some of the quantities of reduced_homotopy.hpp, by linear algebra.
#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>

#include "products.hpp"
#include "reduced_homotopy.hpp"

namespace gsp {

constexpr int kQuadric = 27;  // coefficients: ten of e e, sixteen of e f, one of f.f

class ReducedQuadrics {
 public:
  using Number = std::complex<double>;
  static constexpr int kColumns = kQuantities + kForms + kEquations;

  // Pivots first; columns: the quantities, the form, the combination of the given quadrics.
  Number row[kEquations][kColumns];
  int quantities = 0, pivots = 0;
  std::int32_t pivot[kEquations];

  // Whether the quadrics depend on e e, w and h alone, and can be solved for some of these: for those
  // that are the pivots of others, if there are others. Without `rest`, other rows depend on e e
  // alone. With it they may depend on quantities without pivots, too.
  bool solve(const Number* quadrics, const ReducedQuadrics* others, bool rest) {
    if (!read(quadrics)) return false;
    double largest = 0.0;
    for (int i = 0; i < kEquations; ++i)
      for (int k = 0; k < quantities; ++k) largest = std::max(largest, std::abs(row[i][k]));
    if (others && others->quantities != quantities) return false;
    const int most = others ? others->pivots : kEquations;
    for (pivots = 0; pivots < most; ++pivots) {
      const auto [size, best, column] = choose(others ? others->pivot[pivots] : -1);
      if (!others && (rest ? size < kSmall * largest : size <= kZero * largest)) break;
      if (size < kSmall * largest) return false;
      eliminate(best, column);
    }
    return rest || pivots == kEquations || choose(-1).size <= kZero * largest;
  }

  int free() const { return quantities - pivots; }

  // The quantities that are no pivots, in order.
  void list_free(std::int32_t* out) const {
    for (std::int32_t k = 0; k < quantities; ++k)
      if (std::find(pivot, pivot + pivots, k) == pivot + pivots) *out++ = k;
  }

 private:
  // Pivots below the first part of the largest entry are zero; in between they are too small to
  // divide by.
  static constexpr double kZero = 1e-12, kSmall = 1e-3;

  bool read(const Number* quadrics) {
    double largest = 0.0, rest = 0.0;
    bool has_h = false;
    for (int i = 0; i < kEquations; ++i) {
      const Number *q = quadrics + i * kQuadric, *mixed = q + kForms;
      for (int k = 0; k < kQuadric; ++k) largest = std::max(largest, std::abs(q[k]));
      // e.f vanishes; the rest must be skew.
      for (int a = 0; a < 4; ++a)
        for (int b = 0; b <= a; ++b)
          rest = std::max(rest, std::abs(mixed[4 * a + b] + mixed[4 * b + a] -
                                         (a == b ? 2.0 * mixed[0] : 0.0)));
      constexpr int kPlace[6] = {1, 2, 3, 11, 13, 6};  // of w in the matrix
      Number* r = row[i];
      for (int k = 0; k < 6; ++k) r[k] = mixed[kPlace[k]];
      r[6] = q[kQuadric - 1];
      has_h |= r[6] != 0.0;
      for (int k = 0; k < kForms; ++k) r[kQuantities + k] = q[k];
      for (int k = 0; k < kEquations; ++k) r[kQuantities + kForms + k] = i == k ? 1.0 : 0.0;
    }
    quantities = has_h ? kQuantities : kQuantities - 1;
    return rest <= kZero * largest;
  }

  struct Choice {
    double size;
    int row, column;
  };
  // The largest entry of the rows without pivots, in one column unless that is -1.
  Choice choose(int column) const {
    Choice best{-1.0, 0, 0};
    for (int i = pivots; i < kEquations; ++i)
      for (int k = 0; k < quantities; ++k)
        if ((column < 0 || k == column) && std::abs(row[i][k]) > best.size)
          best = {std::abs(row[i][k]), i, k};
    return best;
  }

  void eliminate(int from, int column) {
    for (int k = 0; k < kColumns; ++k) std::swap(row[pivots][k], row[from][k]);
    const Number scale = 1.0 / row[pivots][column];
    for (Number& x : row[pivots]) x = product(scale, x);
    for (int i = 0; i < kEquations; ++i) {
      if (i == pivots) continue;
      const Number factor = row[i][column];
      for (int k = 0; k < kColumns; ++k) row[i][k] -= product(factor, row[pivots][k]);
      row[i][column] = 0.0;
    }
    pivot[pivots] = column;
  }
};

}  // namespace gsp
