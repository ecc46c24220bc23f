// The seven equations, their Jacobian matrix, its factorization and solutions with it.
//
// Points are in C^8 of norm 1. The Jacobian matrix J has seven rows with J z = 0 on solutions, so
// least-norm solutions of J dz = b are orthogonal to z: the row conj(z).dz = 0 of a moving patch is
// there without being written. J = L Q with L lower triangular and orthonormal rows of Q, by
// modified Gram-Schmidt, which needs no pivoting and so no branches between lanes.
//
// With 64 digits lengths are measured in units of e and of f at the point:
// poses far away are near each other in C^8, where e nearly vanishes, but not in these.
//
// Included by tracker.cpp in each of its builds: all in an anonymous namespace, so that the linker
// cannot merge functions that were compiled for different processors.
#pragma once

#include "quadrics.hpp"

namespace gsp {
namespace {

constexpr int kRows = kEquations + 1;
#if !defined(GSP_ORDER)
#define GSP_ORDER 7
#endif
constexpr int kOrder = GSP_ORDER;  // of the Taylor series
// Where e or f is zero it has no unit of its own.
constexpr double kLeastSquare = 1e-280;

// What one lane-wide step works with.
struct Workspace {
  C row[kRows][N];        // of the Jacobian matrix, then of Q; row 0 is that of e.f
  C lower[kRows][kRows];  // L below its diagonal
  V inverse[kRows];       // of L's diagonal
  V magnitude[kRows];     // of the terms that cancel in the values
  C factor[kQuadrics][N]; // gradients of the factors of products
  C f[kRows];             // values
  D unit[2];              // of e and of f
  // Series of the factors and of N, for products.
  C g[kEquations][kOrder + 1], h[kEquations][kOrder + 1], n[kOrder + 1];
};

constexpr bool kUnits = GSP_PARTS > 2;

INLINE void set_units(Workspace& w, const C* z) {
  if constexpr (kUnits) {
    for (int l = 0; l < W; ++l) {
      double size[2] = {0.0, 0.0};
      for (int i = 0; i < N; ++i) {
        const Complex x = lane(z[i], l);
        size[i / 4] += x.re * x.re + x.im * x.im;
      }
      for (int k = 0; k < 2; ++k)
        w.unit[k][l] = size[k] > kLeastSquare ? __builtin_sqrt(size[k]) : 1.0;
    }
  }
}

// Coordinate i of a vector in its unit; the vector's length.
INLINE C in_units(const Workspace& w, const C& x, int i) {
  return kUnits ? by(1.0 / w.unit[i / 4], x) : x;
}
INLINE V norm(const Workspace& w, const C* x) {
  C scaled[N];
  for (int i = 0; i < N; ++i) scaled[i] = in_units(w, x[i], i);
  return norm(scaled);
}

INLINE C study(const C* z) {
  C s{};
  for (int i = 0; i < 4; ++i) add_product(s, z[i], z[4 + i]);
  return s;
}

// Values and Jacobian matrix at (z, t).
void linearize(const Homotopy& H, Workspace& w, const C* z, const V& t) {
  set_units(w, z);
  w.f[0] = study(z);
  w.magnitude[0] = splat(1.0);
  for (int i = 0; i < N; ++i) w.row[0][i] = z[(i + 4) % N];
  for (int i = 0; i < kEquations; ++i) {
    C* row = w.row[i + 1];
    if (!H.product[i]) {
      w.f[i + 1] = gradient(H.quadric[i], z, t, row);
      w.magnitude[i + 1] = splat(1.0);
      continue;
    }
    C *dg = w.factor[i], *dh = w.factor[i + kEquations];
    const C g = gradient(H.quadric[i], z, t, dg);
    const C h = gradient(H.quadric[i + kEquations], z, t, dh);
    C n{};
    for (int j = 0; j < 4; ++j) add_product(n, z[j], z[j]);
    const C tau_n = line(H.tau_start, H.tau_change, H.tau_more, i, t) * n;
    w.g[i][0] = g;
    w.h[i][0] = h;
    w.n[0] = n;
    w.f[i + 1] = g * h - tau_n * n;
    w.magnitude[i + 1] = root(square(g) + square(h) + square(tau_n));
    for (int j = 0; j < N; ++j) {
      row[j] = g * dh[j];
      add_product(row[j], h, dg[j]);
      if (j < 4) row[j] = row[j] - splat(4.0) * (tau_n * z[j]);
    }
  }
}

// J = L Q, columns of J in their units; the rows of J become those of Q.
void factorize(Workspace& w) {
  if constexpr (kUnits)
    for (int i = 0; i < kRows; ++i)
      for (int j = 0; j < N; ++j) w.row[i][j] = by(w.unit[j / 4], w.row[i][j]);
  for (int j = 0; j < kRows; ++j) {
    C* q = w.row[j];
    const V scale = 1.0 / norm(q);
    w.inverse[j] = scale;
    for (int k = 0; k < N; ++k) q[k] = scale * q[k];
    for (int i = j + 1; i < kRows; ++i) {
      C* r = w.row[i];
      C s{};
      for (int k = 0; k < N; ++k) add_conjugate_product(s, q[k], r[k]);
      for (int k = 0; k < N; ++k) subtract_product(r[k], s, q[k]);
      w.lower[i][j] = s;
    }
  }
}

// b becomes L^-1 b.
void substitute(const Workspace& w, C* b) {
  for (int i = 0; i < kRows; ++i) {
    C s = b[i];
    for (int j = 0; j < i; ++j) subtract_product(s, w.lower[i][j], b[j]);
    b[i] = w.inverse[i] * s;
  }
}

// The solution of J x = b of the least norm in the units; b becomes L^-1 b.
void solve(const Workspace& w, C* b, C* x) {
  substitute(w, b);
  for (int k = 0; k < N; ++k) {
    C s{};
    for (int j = 0; j < kRows; ++j) add_conjugate_product(s, w.row[j][k], b[j]);
    x[k] = kUnits ? by(w.unit[k / 4], s) : s;
  }
}

// About how far rounding in the values moves a solution: the least-norm solution of J x = b for
// one b of the size of the rounding errors, with phases that nothing is special about.
V rounding(const Workspace& w) {
  constexpr double kPhase[kRows][2] = {{1.0, 0.0},   {-0.54, 0.84}, {0.28, 0.96}, {-0.8, -0.6},
                                       {0.6, -0.8},  {0.96, 0.28},  {-0.28, 0.96}};
  C b[kRows];
  for (int i = 0; i < kRows; ++i) {
    const V size = kEpsilon * w.magnitude[i];
    b[i] = {kPhase[i][0] * size, kPhase[i][1] * size};
  }
  substitute(w, b);
  V s = square(b[0]);
  for (int i = 1; i < kRows; ++i) s += square(b[i]);
  return root(s);
}

}  // namespace
}  // namespace gsp
