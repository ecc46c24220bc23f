// Linear equations and eigenvectors of small complex matrices, one matrix in each lane.
//
// Nothing here branches between lanes: equations are solved by orthogonalization, which needs no
// pivots, and the QR algorithm takes as many steps as the slowest lane needs.
//
// Included by intersection.cpp in each of its builds: all in an anonymous namespace, so that the
// linker cannot merge functions that were compiled for different processors.
#pragma once

#include "lanes.hpp"

namespace gsp {
namespace {

INLINE C real(double a) { return {splat(a), V{}}; }
INLINE C conjugate(const C& a) { return {a.re, -a.im}; }
INLINE C operator-(const C& a) { return {-a.re, -a.im}; }
INLINE C operator*(double a, const C& b) { return {a * b.re, a * b.im}; }
INLINE C quotient(const C& a, const C& b) { return (1.0 / square(b)) * (conjugate(b) * a); }

INLINE C root(const C& x) {
  const V re = root(0.5 * (root(square(x)) + maximum(x.re, -x.re)));
  const V im = 0.5 * x.im / select(re > 0.0, re, splat(1.0));
  const C left = {maximum(im, -im), select(x.im < 0.0, -re, re)};
  return select(x.re >= 0.0, C{re, im}, left);
}

// Solves A X = B. A is overwritten, B becomes X.
template <int n, int r>
void solve(C (&a)[n][n], C (&b)[n][r]) {
  C upper[n][n]{}, y[n][r];
  V inverse[n];
  for (int j = 0; j < n; ++j) {
    V s{};
    for (int i = 0; i < n; ++i) s += square(a[i][j]);
    inverse[j] = 1.0 / root(s);
    for (int i = 0; i < n; ++i) a[i][j] = inverse[j] * a[i][j];
    for (int k = j + 1; k < n; ++k) {
      C d{};
      for (int i = 0; i < n; ++i) add_conjugate_product(d, a[i][j], a[i][k]);
      for (int i = 0; i < n; ++i) subtract_product(a[i][k], d, a[i][j]);
      upper[j][k] = d;
    }
    for (int k = 0; k < r; ++k) {
      C d{};
      for (int i = 0; i < n; ++i) add_conjugate_product(d, a[i][j], b[i][k]);
      for (int i = 0; i < n; ++i) subtract_product(b[i][k], d, a[i][j]);
      y[j][k] = d;
    }
  }
  for (int j = n; j-- > 0;)
    for (int k = 0; k < r; ++k) {
      C s = y[j][k];
      for (int l = j + 1; l < n; ++l) subtract_product(s, upper[j][l], b[l][k]);
      b[j][k] = inverse[j] * s;
    }
}

// A becomes the upper Hessenberg matrix P* A P, and R becomes R P, for a unitary P.
template <int n, int r>
void reduce_to_hessenberg(C (&a)[n][n], C (&rows)[r][n]) {
  for (int k = 0; k + 2 < n; ++k) {
    // The reflection I - beta v v* that takes the column below the diagonal to its first entry.
    C v[n];
    V tail{};
    for (int i = k + 2; i < n; ++i) tail += square(v[i] = a[i][k]);
    const C first = a[k + 1][k];
    const V absolute = root(square(first)), size = root(square(first) + tail);
    const Mask zero = absolute == 0.0;
    const C phase = (1.0 / select(zero, splat(1.0), absolute)) * first;
    const C end = size * select(zero, real(1.0), phase);
    v[k + 1] = first + end;
    const V beta = select(size > 0.0, 1.0 / (size * (size + absolute)), splat(0.0));
    a[k + 1][k] = -end;
    for (int i = k + 2; i < n; ++i) a[i][k] = C{};
    for (int j = k + 1; j < n; ++j) {
      C d{};
      for (int i = k + 1; i < n; ++i) add_conjugate_product(d, v[i], a[i][j]);
      d = beta * d;
      for (int i = k + 1; i < n; ++i) subtract_product(a[i][j], d, v[i]);
    }
    const auto from_the_right = [&](C* row) {
      C d{};
      for (int j = k + 1; j < n; ++j) add_product(d, row[j], v[j]);
      d = beta * d;
      for (int j = k + 1; j < n; ++j) subtract_product(row[j], d, conjugate(v[j]));
    };
    for (int i = 0; i < n; ++i) from_the_right(a[i]);
    for (int i = 0; i < r; ++i) from_the_right(rows[i]);
  }
}

// The unitary [c* s*; -s c] that takes (a, b) to (its norm, 0); nothing happens in waiting lanes.
struct Turn {
  C c, s;
};

INLINE Turn turn_of(const C& a, const C& b, const Mask& waits = Mask{}) {
  const V size = square(a) + square(b);
  const Mask none = waits | (size == 0.0);
  const V scale = 1.0 / root(select(none, splat(1.0), size));
  return {select(none, real(1.0), scale * a), select(none, C{}, scale * b)};
}

INLINE void turn_rows(const Turn& g, C& x, C& y) {
  C u{}, w{};
  add_conjugate_product(u, g.c, x);
  add_conjugate_product(u, g.s, y);
  add_product(w, g.c, y);
  subtract_product(w, g.s, x);
  x = u;
  y = w;
}

INLINE void turn_columns(const Turn& g, C& x, C& y) {
  C u{}, w{};
  add_product(u, g.c, x);
  add_product(u, g.s, y);
  add_conjugate_product(w, g.c, y);
  const C s = conjugate(g.s);
  subtract_product(w, s, x);
  x = u;
  y = w;
}

// The eigenvalues of an upper Hessenberg matrix, which is overwritten, by the QR algorithm. A lane
// that has found one waits for the others; one that does not converge has wrong ones.
template <int n>
void eigenvalues(C (&h)[n][n], C (&values)[n]) {
  constexpr double kNegligible = 1e-13;
  constexpr int kMostSweeps = 40, kUnusual = 12;
  for (int last = n - 1; last > 0; --last) {
    for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
      C &a = h[last - 1][last - 1], &b = h[last - 1][last], &c = h[last][last - 1],
        &d = h[last][last];
      const Mask small = square(c) <= kNegligible * kNegligible * (square(a) + square(d));
      bool converged = true;
      for (int l = 0; l < W; ++l) converged &= small[l] != 0;
      if (converged) break;
      // Wilkinson's shift: the eigenvalue of the last 2 x 2 matrix that is nearer to d.
      const C half = 0.5 * (a - d), product = b * c;
      const C r = root(half * half + product);
      const C away = half + select(half.re * r.re + half.im * r.im >= 0.0, r, -r);
      C shift = select(square(away) > 0.0, d - quotient(product, away), d);
      if (sweep % kUnusual == kUnusual - 1) shift = shift + 0.75 * c;
      shift = select(small, C{}, shift);
      Turn turns[n];
      for (int i = 0; i <= last; ++i) h[i][i] = h[i][i] - shift;
      for (int i = 0; i < last; ++i) {
        turns[i] = turn_of(h[i][i], h[i + 1][i], small);
        for (int j = i; j <= last; ++j) turn_rows(turns[i], h[i][j], h[i + 1][j]);
      }
      for (int i = 0; i < last; ++i)
        for (int j = 0; j <= i + 1; ++j) turn_columns(turns[i], h[j][i], h[j][i + 1]);
      for (int i = 0; i <= last; ++i) h[i][i] = h[i][i] + shift;
    }
    values[last] = h[last][last];
  }
  values[0] = h[0][0];
}

// An eigenvector of an upper Hessenberg matrix for a known eigenvalue, by one step of inverse
// iteration: H - value = Q R, and R v = (1, ..., 1).
template <int n>
void eigenvector(const C (&matrix)[n][n], const C& value, C (&v)[n]) {
  C h[n][n];
  V size{};
  for (int i = 0; i < n; ++i)
    for (int j = i > 0 ? i - 1 : 0; j < n; ++j) size += square(h[i][j] = matrix[i][j]);
  for (int i = 0; i < n; ++i) h[i][i] = h[i][i] - value;
  for (int i = 0; i + 1 < n; ++i) {
    const Turn g = turn_of(h[i][i], h[i + 1][i]);
    for (int j = i; j < n; ++j) turn_rows(g, h[i][j], h[i + 1][j]);
  }
  const V least = 1e-32 * size;
  for (int i = n; i-- > 0;) {
    C s = real(1.0);
    for (int j = i + 1; j < n; ++j) subtract_product(s, h[i][j], v[j]);
    v[i] = quotient(s, select(square(h[i][i]) < least, C{root(least), V{}}, h[i][i]));
  }
}

}  // namespace
}  // namespace gsp
