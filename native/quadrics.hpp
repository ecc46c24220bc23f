// Values, gradients and products of series of quadrics on the Study quadric.
//
// Included by tracker.cpp in each of its builds: all in an anonymous namespace, so that the linker
// cannot merge functions that were compiled for different processors.
#pragma once

#include <type_traits>

#include "forms.hpp"

namespace gsp {
namespace {

// The sum over i + j = k of products of the coefficients of two series.
struct Pairs {
  C ee[10], ef[4][4], ff;
};

// The products of x with itself, alone or added to others.
template <bool alone>
INLINE void take_square(Pairs& p, const C* x) {
  take_square<alone>(p.ee, x);
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) take_product<alone>(p.ef[i][j], x[i], x[4 + j]);
  C s = alone ? C{} : p.ff;
  for (int i = 4; i < N; ++i) add_product(s, x[i], x[i]);
  p.ff = s;
}

// The products of x with y and of y with x, likewise.
template <bool alone>
INLINE void take_both(Pairs& p, const C* x, const C* y) {
  take_both<alone>(p.ee, x, y);
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) {
      C s = p.ef[i][j];
      take_product<alone>(s, x[i], y[4 + j]);
      add_product(s, y[i], x[4 + j]);
      p.ef[i][j] = s;
    }
  C s = alone ? C{} : p.ff;
  for (int i = 4; i < N; ++i) add_product(s, x[i] + x[i], y[i]);
  p.ff = s;
}

// The sum over i + j = k of the products of terms i and j > 0 of a series, for k > 1.
INLINE void take_between(Pairs& p, const C (*series)[N], int k) {
  if (k == 2) return take_square<true>(p, series[1]);
  take_both<true>(p, series[1], series[k - 1]);
  for (int i = 2; 2 * i < k; ++i) take_both<false>(p, series[i], series[k - i]);
  if (k % 2 == 0) take_square<false>(p, series[k / 2]);
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

// Calls f(begin, end) for the ranges of features that a quadric uses.
template <class F>
INLINE void ranges(unsigned groups, F&& f) {
  f(0, 10);
  if (groups & kT) f(kOffsetT, kOffsetT + 3);
  if (groups & kU) f(kOffsetU, kOffsetU + 3);
  if (groups & kS) f(kOffsetS, kOffsetS + 9);
  if (groups & kRho) f(kOffsetRho, kOffsetRho + 1);
}

#if defined(GSP_REAL)
using Equations = RealHomotopy;
using Line = RealLine;
using Number = V;
INLINE V change_of(const Line& q, int i) { return splat(q.change[i]); }
INLINE V number(const Line& q, int i, const V& t) { return q.start[i] + t * q.change[i]; }
INLINE V start_of(const Line& q, int i) { return splat(q.start[i]); }
INLINE V value_change(const Equations& H, int i) { return splat(H.value_change[i]); }
INLINE V value_at(const Equations& H, int i, const V& t) {
  return H.value_start[i] + t * H.value_change[i];
}
INLINE Complex tau_change(const Equations& H, int i) { return H.tau_change[i]; }
INLINE C tau(const Equations& H, int i, const V& t) {
  const Complex from = H.tau_start[i], by = H.tau_change[i];
  return {from.re + t * by.re, from.im + t * by.im};
}
#else
using Equations = Homotopy;
using Line = Quadric;
using Number = C;
INLINE auto change_of(const Line& q, int i) { return change_of(q.change, q.more, i); }
INLINE C number(const Line& q, int i, const V& t) { return line(q.start, q.change, q.more, i, t); }
INLINE const Complex& start_of(const Line& q, int i) { return q.start[i]; }
// Values are in the quadrics.
INLINE V value_change(const Equations&, int) { return splat(0.0); }
INLINE V value_at(const Equations&, int, const V&) { return splat(0.0); }
INLINE auto tau_change(const Equations& H, int i) {
  return change_of(H.tau_change, H.tau_more, i);
}
INLINE C tau(const Equations& H, int i, const V& t) {
  return line(H.tau_start, H.tau_change, H.tau_more, i, t);
}
#endif
constexpr bool kReal = std::is_same_v<Equations, RealHomotopy>;

// change.y
INLINE C change(const Line& q, const C* y) {
  C r{};
  ranges(q.groups, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) add_product(r, change_of(q, i), y[i]);
  });
  return r;
}
// start.x + change.y
INLINE C value(const Line& q, const C* x, const C* y) {
  C s{}, r{};
  ranges(q.groups, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      add_product(s, start_of(q, i), x[i]);
      add_product(r, change_of(q, i), y[i]);
    }
  });
  return s + r;
}

// A quadric at one t: its second derivatives by e, by e and f, and by f.
struct Hessian {
  Number ee[10], ef[4][4], ff;
};

INLINE void hessian(const Line& q, const V& t, Hessian& h) {
  int n = 0;
  for (int i = 0; i < 4; ++i) {
    const Number c = number(q, n, t);
    h.ee[n++] = c + c;
    for (int j = i + 1; j < 4; ++j, ++n) h.ee[n] = number(q, n, t);
  }
  if (q.groups & (kT | kU | kS)) {
    for (int i = 1; i < 4; ++i) {
      Number a{}, b{};  // of e0 f_i - e_i f0 and of (e x f)_i
      if (q.groups & kT) a = b = number(q, kOffsetT + i - 1, t);
      if (q.groups & kU) {
        const Number u = number(q, kOffsetU + i - 1, t);
        a = a + u;
        b = b - u;
      }
      const int j = i % 3 + 1, k = j % 3 + 1;
      h.ef[0][i] = a, h.ef[i][0] = Number{} - a;
      h.ef[j][k] = b, h.ef[k][j] = Number{} - b;
    }
  }
  if (q.groups & kS) {
    n = kOffsetS;
    h.ef[0][0] = Number{};
    for (int i = 0; i < 4; ++i)
      for (int j = i + 1; j < 4; ++j) {
        const Number c = number(q, n++, t);
        h.ef[i][j] = h.ef[i][j] + c, h.ef[j][i] = h.ef[j][i] + c;
      }
    for (int i = 1; i < 4; ++i) h.ef[i][i] = number(q, n++, t);
  }
  if (q.groups & kRho) {
    const Number c = number(q, kOffsetRho, t);
    h.ff = c + c;
  }
}

// g_e = ee e + ef f and g_f = ef^T e.
template <bool diagonal>
INLINE void add_mixed(const Hessian& h, const C* e, const C* f, C* g) {
  for (int i = 0; i < 4; ++i) {
    C s = g[i];
    for (int j = 0; j < 4; ++j)
      if (diagonal ? i + j > 0 : i != j) add_product(s, h.ef[i][j], f[j]);
    g[i] = s;
  }
  for (int i = 0; i < 4; ++i) {
    C s{};
    for (int j = 0; j < 4; ++j)
      if (diagonal ? i + j > 0 : i != j) add_product(s, h.ef[j][i], e[j]);
    g[4 + i] = s;
  }
}

// The gradient of a quadric at z; returns its value.
INLINE C gradient(unsigned groups, const Hessian& h, const C* z, C* g) {
  constexpr int kPlace[4][4] = {{0, 1, 2, 3}, {1, 4, 5, 6}, {2, 5, 7, 8}, {3, 6, 8, 9}};
  const C *e = z, *f = z + 4;
  for (int i = 0; i < 4; ++i) {
    C s{};
    for (int j = 0; j < 4; ++j) add_product(s, h.ee[kPlace[i][j]], e[j]);
    g[i] = s;
    g[4 + i] = C{};
  }
  if (groups & kS)
    add_mixed<true>(h, e, f, g);
  else if (groups & (kT | kU))
    add_mixed<false>(h, e, f, g);
  if (groups & kRho)
    for (int i = 0; i < 4; ++i) add_product(g[4 + i], h.ff, f[i]);
  C s{}, r{};
  for (int i = 0; i < 4; ++i) add_product(s, g[i], e[i]), add_product(r, g[4 + i], f[i]);
  s = s + r;
  return {0.5 * s.re, 0.5 * s.im};
}

}  // namespace
}  // namespace gsp
