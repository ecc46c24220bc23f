// The seven equations, their Jacobian matrix, its factorization and solutions with it.
//
// Points are in C^8 of norm 1. The Jacobian matrix J has seven rows with J z = 0 on solutions, so
// least-norm solutions of J dz = b are orthogonal to z: the row conj(z).dz = 0 of a moving patch is
// satisfied without being stated.
//
// Included by tracker.cpp in each of its builds: all in an anonymous namespace, so that the linker
// cannot merge functions that were compiled for different processors.
#pragma once

#include "factorization.hpp"
#include "quadrics.hpp"

namespace gsp {
namespace {

constexpr int kRows = kEquations + 1;
#if !defined(GSP_ORDER)
#define GSP_ORDER 7
#endif
constexpr int kOrder = GSP_ORDER;  // of the Taylor series

// The numbers of one step in all lanes.
struct Workspace {
  C row[kRows][N];        // of the Jacobian matrix, then of R; row 0 is that of e.f
  C lower[kRows][kRows];  // L below its diagonal
  V inverse[kRows];       // of the squares of the lengths of R's rows
  V magnitude[kRows];     // of the terms that cancel in the values
  C factor[kQuadrics][N]; // gradients of the factors of products
  C f[kRows];             // values
  Hessian hessian[kQuadrics];  // at t, where `go` went
  C tau[kEquations];
  V value[kEquations];    // imaginary parts of quadrics that are real but for a multiple of N
  // Series of the factors and of N, for products.
  C g[kEquations][kOrder + 1], h[kEquations][kOrder + 1], n[kOrder + 1];
};

// s += i a b
INLINE void add_times_i(C& s, const V& a, const C& b) {
  s.re -= a * b.im;
  s.im += a * b.re;
}

INLINE C study(const C* z) {
  C s{};
  for (int i = 0; i < 4; ++i) add_product(s, z[i], z[4 + i]);
  return s;
}

// The equations at t.
void go(const Equations& H, Workspace& w, const V& t) {
  for (int i = 0; i < kEquations; ++i) {
    hessian(H.quadric[i], t, w.hessian[i]);
    if (H.product[i]) {
      hessian(H.quadric[i + kEquations], t, w.hessian[i + kEquations]);
      w.tau[i] = tau(H, i, t);
    } else if constexpr (kReal) {
      w.value[i] = value_at(H, i, t);
    }
  }
}

// The product of two factors: (A + iB) (A - iB) if A and B are what is known.
INLINE C product_of(const C& g, const C& h) { return kReal ? g * g + h * h : g * h; }

// Values and Jacobian matrix at z.
void linearize(const Equations& H, Workspace& w, const C* z) {
  C n{};
  for (int j = 0; j < 4; ++j) add_product(n, z[j], z[j]);
  w.n[0] = n;
  w.f[0] = study(z);
  w.magnitude[0] = splat(1.0);
  for (int i = 0; i < N; ++i) w.row[0][i] = z[(i + 4) % N];
  for (int i = 0; i < kEquations; ++i) {
    C* row = w.row[i + 1];
    if (!H.product[i]) {
      C g = gradient(H.quadric[i].groups, w.hessian[i], z, row);
      if constexpr (kReal) {
        add_times_i(g, w.value[i], n);
        const V twice = w.value[i] + w.value[i];
        for (int j = 0; j < 4; ++j) add_times_i(row[j], twice, z[j]);
      }
      w.f[i + 1] = g;
      w.magnitude[i + 1] = splat(1.0);
      continue;
    }
    C *dg = w.factor[i], *dh = w.factor[i + kEquations];
    const C g = gradient(H.quadric[i].groups, w.hessian[i], z, dg);
    const C h = gradient(H.quadric[i + kEquations].groups, w.hessian[i + kEquations], z, dh);
    const C tau_n = w.tau[i] * n;
    w.g[i][0] = g;
    w.h[i][0] = h;
    w.f[i + 1] = product_of(g, h) - tau_n * n;
    const V factors = square(g) + square(h);
    w.magnitude[i + 1] = root((kReal ? factors + factors : factors) + square(tau_n));
    const C by_g = kReal ? g + g : h, by_h = kReal ? h + h : g;
    const C by_n = splat(4.0) * tau_n;
    for (int j = 0; j < N; ++j) {
      C s = by_g * dg[j];
      add_product(s, by_h, dh[j]);
      if (j < 4) subtract_product(s, by_n, z[j]);
      row[j] = s;
    }
  }
}

// J = L R; the rows of J become those of R.
void factorize(Workspace& w) { factorize<kRows>(w.row, w.lower, w.inverse); }

// b becomes L^-1 b.
void substitute(const Workspace& w, C* b) {
  for (int i = 1; i < kRows; ++i) {
    C s = b[i];
    for (int j = 0; j < i; ++j) subtract_product(s, w.lower[i][j], b[j]);
    b[i] = s;
  }
}

// The solution of J x = b of the least norm; b is used up.
void solve(const Workspace& w, C* b, C* x) {
  substitute(w, b);
  for (int j = 0; j < kRows; ++j) b[j] = w.inverse[j] * b[j];
  for (int k = 0; k < N; ++k) {
    Sum sum{};
    for (int j = 0; j < kRows; ++j) sum.add(w.row[j][k], b[j]);
    x[k] = sum.conjugate_total();
  }
}

// About how far rounding in the values moves a solution: the least-norm solution of J x = b for
// one b of the size of the rounding errors, with phases in general position.
V rounding(const Workspace& w) {
  constexpr double kPhase[kRows][2] = {{1.0, 0.0},   {-0.54, 0.84}, {0.28, 0.96}, {-0.8, -0.6},
                                       {0.6, -0.8},  {0.96, 0.28},  {-0.28, 0.96}};
  C b[kRows];
  for (int i = 0; i < kRows; ++i) {
    const V size = kEpsilon * w.magnitude[i];
    b[i] = {kPhase[i][0] * size, kPhase[i][1] * size};
  }
  substitute(w, b);
  V s = w.inverse[0] * square(b[0]);
  for (int i = 1; i < kRows; ++i) s += w.inverse[i] * square(b[i]);
  return root(s);
}

}  // namespace
}  // namespace gsp
