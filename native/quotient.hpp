// Multiplication modulo n quadrics in affine n-space, n = 1, 2, 3.
//
// In general the products of different coordinates are a basis of the polynomials modulo the
// quadrics: 2^n of them, written as sets of coordinates, one bit each. Products x^2 s, s a set
// without x, are reduced to the basis one degree after the other; those of one degree are unknowns
// of linear equations. This is elimination in Macaulay's matrix of degree n + 1 by blocks. See
// D. Cox, J. Little, D. O'Shea, Using Algebraic Geometry, chapters 2 and 3.
//
// Included by intersection.cpp in each of its builds: all in an anonymous namespace, so that the
// linker cannot merge functions that were compiled for different processors.
#pragma once

#include "eigenpairs.hpp"

namespace gsp {
namespace {

constexpr int degree(int set) { return __builtin_popcount(static_cast<unsigned>(set)); }

template <int n>
struct Quotient {
  static constexpr int kSize = 1 << n;

  // forms[k][i][j], symmetric, of (1, x_1 ... x_n).
  explicit Quotient(const C (&forms)[n][n + 1][n + 1]) {
    C left[n][n], right[n][kSize];
    for (int k = 0; k < n; ++k) {
      const auto& q = forms[k];
      for (int x = 0; x < n; ++x) left[k][x] = q[x + 1][x + 1];
      for (int set = 0; set < kSize; ++set) right[k][set] = C{};
      right[k][0] = -q[0][0];
      for (int x = 0; x < n; ++x) right[k][1 << x] = -2.0 * q[0][x + 1];
      for (int x = 0; x < n; ++x)
        for (int y = x + 1; y < n; ++y) right[k][1 << x | 1 << y] = -2.0 * q[x + 1][y + 1];
    }
    solve(left, right);
    for (int x = 0; x < n; ++x)
      for (int set = 0; set < kSize; ++set) squares_[x][0][set] = right[x][set];
    if constexpr (n > 1) reduce_degree<1>();
    if constexpr (n > 2) reduce_degree<2>();
  }

  // Row s has the coefficients of x_1 s.
  void first_multiplication(C (&matrix)[kSize][kSize]) const {
    for (int set = 0; set < kSize; ++set)
      for (int t = 0; t < kSize; ++t)
        matrix[set][t] = set & 1 ? squares_[0][set & ~1][t]
                                 : real(t == (set | 1));
  }

 private:
  // squares_[x][s][t]: the coefficient of t in x^2 s.
  C squares_[n][kSize][kSize];

  // Reduces x^2 s for the sets s of d coordinates: as y times x^2 (s - y), for one y of s.
  template <int d>
  void reduce_degree() {
    constexpr int kUnknowns = n * (n - 1) / d;  // n times binomial(n - 1, d), for n <= 3
    int number[n][kSize], count = 0;
    for (int x = 0; x < n; ++x)
      for (int set = 0; set < kSize; ++set)
        if (!(set >> x & 1) && degree(set) == d) number[x][set] = count++;
    C left[kUnknowns][kUnknowns], right[kUnknowns][kSize];
    for (int x = 0; x < n; ++x)
      for (int set = 0; set < kSize; ++set) {
        if (set >> x & 1 || degree(set) != d) continue;
        // The next coordinate after x, cyclically, that is in the set.
        int y = (x + 1) % n;
        while (!(set >> y & 1)) y = (y + 1) % n;
        const int row = number[x][set];
        for (int k = 0; k < kUnknowns; ++k) left[row][k] = real(k == row);
        for (int t = 0; t < kSize; ++t) right[row][t] = C{};
        const C* lower = squares_[x][set & ~(1 << y)];
        for (int t = 0; t < kSize; ++t) {
          const int rest = t & ~(1 << y);
          if (rest == t)
            right[row][t | 1 << y] = right[row][t | 1 << y] + lower[t];
          else if (degree(rest) == d)
            left[row][number[y][rest]] = left[row][number[y][rest]] - lower[t];
          else if (degree(rest) < d)
            for (int u = 0; u < kSize; ++u)
              add_product(right[row][u], lower[t], squares_[y][rest][u]);
        }
      }
    solve(left, right);
    for (int x = 0; x < n; ++x)
      for (int set = 0; set < kSize; ++set)
        if (!(set >> x & 1) && degree(set) == d)
          for (int t = 0; t < kSize; ++t) squares_[x][set][t] = right[number[x][set]][t];
  }
};

}  // namespace
}  // namespace gsp
