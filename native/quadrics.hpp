// Values, gradients and products of series of quadrics on the Study quadric.
//
// Included by tracker.cpp in each of its builds: all in an anonymous namespace, so that the linker
// cannot merge functions that were compiled for different processors.
#pragma once

#include "lanes.hpp"

namespace gsp {
namespace {

// The sum over i + j = k of products of the coefficients of two series.
struct Pairs {
  C ee[10], ef[4][4], ff;
};

INLINE void clear(Pairs& p) { p = Pairs{}; }

// Adds the products of x with itself.
INLINE void add_square(Pairs& p, const C* x) {
  int n = 0;
  for (int i = 0; i < 4; ++i)
    for (int j = i; j < 4; ++j) add_product(p.ee[n++], x[i], x[j]);
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) add_product(p.ef[i][j], x[i], x[4 + j]);
  for (int i = 4; i < N; ++i) add_product(p.ff, x[i], x[i]);
}

// Adds the products of x with y and of y with x.
INLINE void add_both(Pairs& p, const C* x, const C* y) {
  int n = 0;
  for (int i = 0; i < 4; ++i) {
    add_product(p.ee[n++], x[i] + x[i], y[i]);
    for (int j = i + 1; j < 4; ++j, ++n) {
      C s = p.ee[n];
      add_product(s, x[i], y[j]);
      add_product(s, x[j], y[i]);
      p.ee[n] = s;
    }
  }
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) {
      C s = p.ef[i][j];
      add_product(s, x[i], y[4 + j]);
      add_product(s, y[i], x[4 + j]);
      p.ef[i][j] = s;
    }
  C s = p.ff;
  for (int i = 4; i < N; ++i) add_product(s, x[i] + x[i], y[i]);
  p.ff = s;
}

INLINE void features(const Pairs& p, C* phi) {
  for (int i = 0; i < 10; ++i) phi[i] = p.ee[i];
  for (int i = 1; i < 4; ++i) {
    const int j = i % 3 + 1, k = j % 3 + 1;
    const C d = p.ef[0][i] - p.ef[i][0], x = p.ef[j][k] - p.ef[k][j];
    phi[kOffsetT + i - 1] = d + x;
    phi[kOffsetU + i - 1] = d - x;
  }
  int n = kOffsetS;
  for (int i = 0; i < 4; ++i)
    for (int j = i + 1; j < 4; ++j) phi[n++] = p.ef[i][j] + p.ef[j][i];
  for (int i = 1; i < 4; ++i) phi[n++] = p.ef[i][i];
  phi[kOffsetRho] = p.ff;
}

INLINE C norm_form(const Pairs& p) { return p.ee[0] + p.ee[4] + p.ee[7] + p.ee[9]; }

// Calls f(begin, end) for the ranges of features that a quadric uses.
template <class F>
INLINE void ranges(unsigned groups, F&& f) {
  f(0, 10);
  if (groups & kT) f(kOffsetT, kOffsetT + 3);
  if (groups & kU) f(kOffsetU, kOffsetU + 3);
  if (groups & kS) f(kOffsetS, kOffsetS + 9);
  if (groups & kRho) f(kOffsetRho, kOffsetRho + 1);
}

// start.x + change.y
INLINE C value(const Quadric& q, const C* x, const C* y) {
  C s{}, r{};
  ranges(q.groups, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      add_product(s, q.start[i], x[i]);
      add_product(r, change_of(q.change, q.more, i), y[i]);
    }
  });
  return s + r;
}

// The gradient of a quadric at z; returns its value.
INLINE C gradient(const Quadric& q, const C* z, const V& t, C* g) {
  const C *e = z, *f = z + 4;
  for (int i = 0; i < N; ++i) g[i] = C{};
  const auto coefficient = [&](int i) { return line(q.start, q.change, q.more, i, t); };
  int n = 0;
  for (int i = 0; i < 4; ++i) {
    const C square_term = coefficient(n++);
    add_product(g[i], square_term + square_term, e[i]);
    for (int j = i + 1; j < 4; ++j) {
      const C c = coefficient(n++);
      add_product(g[i], c, e[j]);
      add_product(g[j], c, e[i]);
    }
  }
  if (q.groups & (kT | kU)) {
    for (int i = 1; i < 4; ++i) {
      C a{}, b{};  // of e0 f_i - e_i f0 and of (e x f)_i
      if (q.groups & kT) a = b = coefficient(kOffsetT + i - 1);
      if (q.groups & kU) {
        const C u = coefficient(kOffsetU + i - 1);
        a = a + u;
        b = b - u;
      }
      const int j = i % 3 + 1, k = j % 3 + 1;
      add_product(g[0], a, f[i]);
      subtract_product(g[i], a, f[0]);
      add_product(g[4 + i], a, e[0]);
      subtract_product(g[4], a, e[i]);
      add_product(g[j], b, f[k]);
      subtract_product(g[k], b, f[j]);
      add_product(g[4 + k], b, e[j]);
      subtract_product(g[4 + j], b, e[k]);
    }
  }
  if (q.groups & kS) {
    n = kOffsetS;
    for (int i = 0; i < 4; ++i)
      for (int j = i + 1; j < 4; ++j) {
        const C c = coefficient(n++);
        add_product(g[i], c, f[j]);
        add_product(g[j], c, f[i]);
        add_product(g[4 + i], c, e[j]);
        add_product(g[4 + j], c, e[i]);
      }
    for (int i = 1; i < 4; ++i) {
      const C c = coefficient(n++);
      add_product(g[i], c, f[i]);
      add_product(g[4 + i], c, e[i]);
    }
  }
  if (q.groups & kRho) {
    C c = coefficient(kOffsetRho);
    c = c + c;
    for (int i = 0; i < 4; ++i) add_product(g[4 + i], c, f[i]);
  }
  C s{};
  for (int i = 0; i < N; ++i) add_product(s, g[i], z[i]);
  return {0.5 * s.re, 0.5 * s.im};
}

}  // namespace
}  // namespace gsp
