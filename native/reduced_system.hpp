// The equations of reduced_homotopy.hpp, their derivatives and the Taylor series of paths, one in each lane.
//
// Included by each build of reduced_homotopy.cpp: all in an anonymous namespace.
#pragma once

#include <cstddef>

#include "factorization.hpp"
#include "forms.hpp"
#include "reduced_moving.hpp"

namespace gsp {
namespace {

INLINE C conjugate(const C& a) { return {a.re, -a.im}; }
INLINE C number_of(const C& a) { return a; }
INLINE C number_of(const V& a) { return {a, splat(0.0)}; }
INLINE C number_of(double a) { return {splat(a), splat(0.0)}; }

// r += (e ^ w), four components of which three are independent where e is not zero.
INLINE void add_wedge(C* r, const C* w, const C* e) {
  add_product(r[0], e[1], w[3]), add_product(r[0], e[2], w[4]), add_product(r[0], e[3], w[5]);
  subtract_product(r[1], e[0], w[3]), add_product(r[1], e[2], w[2]), subtract_product(r[1], e[3], w[1]);
  subtract_product(r[2], e[0], w[4]), add_product(r[2], e[3], w[0]), subtract_product(r[2], e[1], w[2]);
  subtract_product(r[3], e[0], w[5]), add_product(r[3], e[1], w[1]), subtract_product(r[3], e[2], w[0]);
}
// Coordinate k of w is in component `plus` times e[plus_e], in `minus` times -e[minus_e].
struct Wedge {
  int plus, plus_e, minus, minus_e;
};
constexpr Wedge kWedge[6] = {{2, 3, 3, 2}, {3, 1, 1, 3}, {1, 2, 2, 1},
                             {0, 1, 1, 0}, {0, 2, 2, 0}, {0, 3, 3, 0}};

// The vectors from which a series in D coordinates is computed.
template <int D>
struct Expansion {
  C x[D];                     // where it is expanded
  C q[kQuantities], n;        // values of the quantities and of N there
  C slope[kQuantities][4];    // derivatives of the quantities by e
  C row[D][D], lower[D][D];   // of the Jacobian matrix, then of its factors R and L
  V inverse[D];               // of the squares of the lengths of R's rows

  // The numbers of one path in a lane.
  INLINE void give(int l, double* out) const {
    const V* const given = reinterpret_cast<const V*>(this);
    for (std::size_t i = 0; i < sizeof(Expansion) / sizeof(V); ++i) out[i] = lane(given[i], l);
  }
  INLINE void take(int l, const double* given) {
    V* const to = reinterpret_cast<V*>(this);
    for (std::size_t i = 0; i < sizeof(Expansion) / sizeof(V); ++i) put(to[i], l, given[i]);
  }
};

// The equations in e and M scalars: 4 of e ^ w, with h the quadric of w, then those without pivots.
template <int M, bool has_h, class Moving>
struct System : Expansion<4 + M> {
  // Coordinates; pivots; the first equation without a pivot.
  static constexpr int kOrder = Moving::kOrder;
  static constexpr int D = 4 + M, P = (has_h ? 7 : 6) - M, F = has_h ? 5 : 4;
  using At = Expansion<D>;
  using At::inverse, At::lower, At::n, At::q, At::row, At::slope, At::x;

  const ReducedGeometry& geometry;
  Moving moving;
  C f[D];                     // values of the equations

  System(const ReducedGeometry& given, const ReducedPaths& paths)
      : geometry(given), moving{given, paths} {}

  // The quantities, equations and Jacobian matrix at z.
  void linearize(const C* z) {
    measure(z);
    values();
    derivatives();
  }

  // The quantities and their derivatives at z.
  void measure(const C* z) {
    const C* const e = x;
    for (int i = 0; i < D; ++i) x[i] = z[i];
    n = C{};
    for (int i = 0; i < 4; ++i) add_product(n, e[i], e[i]);
    for (int j = 0; j < kEquations; ++j) {
      C half[4], value{};
      moving.half_gradient(j, e, half);
      for (int a = 0; a < 4; ++a) add_product(value, e[a], half[a]);
      if (j >= P) {
        f[F + j - P] = value;
        for (int a = 0; a < 4; ++a) row[F + j - P][a] = half[a] + half[a];
        for (int l = 0; l < M; ++l) {
          subtract_times(f[F + j - P], minus(moving.slope(j, l)), x[4 + l]);
          row[F + j - P][4 + l] = number_of(moving.slope(j, l));
        }
        continue;
      }
      const int k = geometry.pivot[j];
      q[k] = minus(value);
      for (int l = 0; l < M; ++l) subtract_times(q[k], moving.slope(j, l), x[4 + l]);
      for (int a = 0; a < 4; ++a) slope[k][a] = minus(half[a] + half[a]);
    }
    for (int l = 0; l < M; ++l) {
      const int k = geometry.free[l];
      q[k] = x[4 + l];
      for (int a = 0; a < 4; ++a) slope[k][a] = C{};
    }
  }

  INLINE void values() {
    for (int i = 0; i < F; ++i) f[i] = C{};
    add_wedge(f, q, x);
    if constexpr (!has_h) return;
    for (int k = 0; k < 6; ++k) add_product(f[4], q[k], q[k]);
    subtract_product(f[4], n, q[6]);
  }

  // The derivative of equation i by quantity k, times c, into a column.
  INLINE void add_quantity(int k, int column, const C& c) {
    if (has_h && k == 6) {
      subtract_product(row[4][column], n, c);
      return;
    }
    const Wedge& t = kWedge[k];
    add_product(row[t.plus][column], x[t.plus_e], c);
    subtract_product(row[t.minus][column], x[t.minus_e], c);
    if constexpr (has_h) add_product(row[4][column], q[k] + q[k], c);
  }
  template <class Real>
  INLINE void add_quantity(int k, int column, const Real& c) {
    if (has_h && k == 6) {
      add_real(row[4][column], minus(c), n);
      return;
    }
    const Wedge& t = kWedge[k];
    add_real(row[t.plus][column], c, x[t.plus_e]);
    add_real(row[t.minus][column], minus(c), x[t.minus_e]);
    if constexpr (has_h) add_real(row[4][column], 2.0 * c, q[k]);
  }

  INLINE void derivatives() {
    const C* w = q;
    const C zero{};
    const C skew[4][4] = {{zero, w[3], w[4], w[5]},
                          {minus(w[3]), zero, w[2], minus(w[1])},
                          {minus(w[4]), minus(w[2]), zero, w[0]},
                          {minus(w[5]), w[1], minus(w[0]), zero}};
    for (int i = 0; i < 4; ++i) {
      // The combination of e ^ w by e vanishes: the moving patch takes its place.
      for (int a = 0; a < 4; ++a) {
        row[i][a] = skew[i][a];
        add_product(row[i][a], conjugate(x[i]), conjugate(x[a]));
      }
      for (int l = 0; l < M; ++l) row[i][4 + l] = C{};
    }
    if constexpr (has_h) {
      for (int a = 0; a < 4; ++a) row[4][a] = minus((q[6] + q[6]) * x[a]);
      for (int l = 0; l < M; ++l) row[4][4 + l] = C{};
    }
    for (int j = 0; j < P; ++j) {
      const int k = geometry.pivot[j];
      for (int a = 0; a < 4; ++a) add_quantity(k, a, slope[k][a]);
      for (int l = 0; l < M; ++l) add_quantity(k, 4 + l, minus(moving.slope(j, l)));
    }
    for (int l = 0; l < M; ++l) add_quantity(geometry.free[l], 4 + l, 1.0);
  }

  void factorize() { gsp::factorize<D>(row, lower, inverse); }

  INLINE void solve(const C* given, C* result) const {
    C b[D];
    for (int i = 0; i < D; ++i) {
      C s = given[i];
      for (int j = 0; j < i; ++j) subtract_product(s, lower[i][j], b[j]);
      b[i] = s;
    }
    for (int i = 0; i < D; ++i) b[i] = inverse[i] * b[i];
    for (int k = 0; k < D; ++k) {
      C s{};
      for (int j = 0; j < D; ++j) add_conjugate_product(s, row[j][k], b[j]);
      result[k] = s;
    }
  }

  // The Taylor series of the path through x, with the factors of its Jacobian matrix.
  void expand(C (*series)[D]) const {
    C quantity[kOrder + 1][kQuantities], norm[kOrder + 1], before[kForms], pairs[kForms];
    for (int k = 0; k < kQuantities; ++k) quantity[0][k] = q[k];
    norm[0] = n;
    for (int i = 0; i < D; ++i) series[0][i] = x[i];
    take_square<true>(before, x);
    for (int k = 1; k <= kOrder; ++k) {
      norm[k] = C{};
      if (k > 1) {
        take_between(pairs, series, k);
        norm[k] = norm_form(pairs);
      }
      const Orders at{pairs, before, norm[k], norm[k - 1], series[k - 1] + 4};
      C b[D];
      for (int i = 0; i < D; ++i) b[i] = C{};
      C* now = quantity[k];
      for (int l = 0; l < M; ++l) now[geometry.free[l]] = C{};
      for (int j = 0; j < kEquations; ++j) {
        const C s = moving.next(j, k, at);
        if (j < P) now[geometry.pivot[j]] = s;
        else b[F + j - P] = s;
      }
      right_hand_side(k, series, quantity, norm, b);
      solve(b, series[k]);
      if (k == kOrder) break;
      complete(series[k], now, norm[k]);
      if (k > 1) {
        take_both<false>(pairs, x, series[k]);
        for (int i = 0; i < kForms; ++i) before[i] = pairs[i];
      } else {
        take_both<true>(before, x, series[k]);
      }
    }
  }

  // The sum over i + j = k of the products of terms i and j > 0 of a series, for k > 1.
  static INLINE void take_between(C* pairs, const C (*series)[D], int k) {
    if (k == 2) return take_square<true>(pairs, series[1]);
    take_both<true>(pairs, series[1], series[k - 1]);
    for (int i = 2; 2 * i < k; ++i) take_both<false>(pairs, series[i], series[k - i]);
    if (k % 2 == 0) take_square<false>(pairs, series[k / 2]);
  }

  // The negative of the equations of order k without the terms that are linear in that order.
  INLINE void right_hand_side(int k, const C (*series)[D], const C (*quantity)[kQuantities],
                              const C* norm, C* b) const {
    C wedge[4] = {};
    add_wedge(wedge, quantity[k], x);
    for (int i = 1; i < k; ++i) add_wedge(wedge, quantity[i], series[k - i]);
    for (int i = 0; i < 4; ++i) b[i] = minus(wedge[i]);
    if constexpr (!has_h) return;
    C quadric{};
    for (int p = 0; p < 6; ++p) add_product(quadric, q[p], quantity[k][p]);
    for (int i = 1; 2 * i < k; ++i)
      for (int p = 0; p < 6; ++p) add_product(quadric, quantity[i][p], quantity[k - i][p]);
    quadric = quadric + quadric;
    if (k % 2 == 0)
      for (int p = 0; p < 6; ++p) add_product(quadric, quantity[k / 2][p], quantity[k / 2][p]);
    for (int i = 0; i <= k; ++i) subtract_product(quadric, norm[i], quantity[k - i][6]);
    b[4] = minus(quadric);
  }

  // Adds the terms that are linear in the order.
  INLINE void complete(const C* y, C* now, C& norm) const {
    for (int j = 0; j < P; ++j) {
      const int k = geometry.pivot[j];
      for (int a = 0; a < 4; ++a) add_product(now[k], slope[k][a], y[a]);
      for (int l = 0; l < M; ++l) subtract_times(now[k], moving.slope(j, l), y[4 + l]);
    }
    for (int l = 0; l < M; ++l) now[geometry.free[l]] = y[4 + l];
    for (int a = 0; a < 4; ++a) add_product(norm, x[a] + x[a], y[a]);
  }
};

// The Study point of a solution: N times e and f.
template <int M, bool has_h, class Moving>
void to_study(const System<M, has_h, Moving>& s, C* z) {
  const C *e = s.x, *w = s.q;
  C* f = z + 4;
  for (int i = 0; i < 4; ++i) z[i] = s.n * e[i], f[i] = C{};
  subtract_product(f[0], e[1], w[0]), subtract_product(f[0], e[2], w[1]), subtract_product(f[0], e[3], w[2]);
  add_product(f[1], e[0], w[0]), subtract_product(f[1], e[2], w[5]), add_product(f[1], e[3], w[4]);
  add_product(f[2], e[0], w[1]), add_product(f[2], e[1], w[5]), subtract_product(f[2], e[3], w[3]);
  add_product(f[3], e[0], w[2]), subtract_product(f[3], e[1], w[4]), add_product(f[3], e[2], w[3]);
}

}  // namespace
}  // namespace gsp
