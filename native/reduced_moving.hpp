// The moving numbers on the paths of reduced_homotopy.hpp: only values, or all coefficients.
//
// Included by each build of reduced_homotopy.cpp: all in an anonymous namespace.
#pragma once

#include "lanes.hpp"
#include "reduced_homotopy.hpp"

namespace gsp {
namespace {

INLINE void add_real(C& s, double a, const C& b) {
  s.re += a * b.re;
  s.im += a * b.im;
}
INLINE void add_real(C& s, const V& a, const C& b) {
  s.re += a * b.re;
  s.im += a * b.im;
}
// s += i a b
INLINE void add_times_i(C& s, const V& a, const C& b) {
  s.re -= a * b.im;
  s.im += a * b.re;
}
INLINE C minus(const C& a) { return {-a.re, -a.im}; }
INLINE V minus(const V& a) { return -a; }
INLINE double minus(double a) { return -a; }
INLINE void subtract_times(C& s, double a, const C& b) {
  s.re -= a * b.re;
  s.im -= a * b.im;
}
INLINE void subtract_times(C& s, const V& a, const C& b) {
  s.re -= a * b.re;
  s.im -= a * b.im;
}
INLINE void subtract_times(C& s, const C& a, const C& b) { subtract_product(s, a, b); }

// Orders of a series that what is next in it depends on: products of e of the order without what is
// linear in it, and of the order before; N of both; the scalars of the order before.
struct Orders {
  const C *pairs, *before;
  const C &n, &n_before;
  const C* scalars;
};

// Forms and slopes of one geometry, the values moving from those of a start to those of a target,
// another in each lane.
struct MovingValues {
  static constexpr int kOrder = 3;  // of the Taylor series
  const ReducedGeometry& geometry;
  const ReducedPaths& paths;
  C from[kEquations]{}, change[kEquations]{}, v[kEquations]{};

  INLINE void load(int l, int target) {
    const int start = paths.start[target];
    for (int j = 0; j < kEquations; ++j) {
      const Complex a = paths.start_values[start * kEquations + j];
      const Complex b = paths.values[target * kEquations + j];
      put(from[j], l, a);
      put(change[j], l, {b.re - a.re, b.im - a.im});
    }
  }
  INLINE void go(const V& t) {
    for (int j = 0; j < kEquations; ++j) {
      v[j].re = from[j].re + t * change[j].re;
      v[j].im = from[j].im + t * change[j].im;
    }
  }
  INLINE void arrive(int l, int target) {
    for (int j = 0; j < kEquations; ++j) put(v[j], l, paths.values[target * kEquations + j]);
  }

  // Half the gradient of form j minus its value times N.
  INLINE void half_gradient(int j, const C* e, C* half) const {
    const double* c = geometry.form[j];
    for (int a = 0; a < 4; ++a) {
      half[a] = C{};
      subtract_product(half[a], v[j], e[a]);
    }
    for (int a = 0, k = 0; a < 4; ++a) {
      add_real(half[a], c[k++], e[a]);
      for (int b = a + 1; b < 4; ++b, ++k) {
        add_real(half[a], 0.5 * c[k], e[b]);
        add_real(half[b], 0.5 * c[k], e[a]);
      }
    }
  }
  INLINE double slope(int j, int l) const { return geometry.slope[j][l]; }
  // The negative of equation j in the next order.
  INLINE C next(int j, int order, const Orders& at) const {
    C s{};
    add_product(s, change[j], at.n_before);
    if (order == 1) return s;
    add_product(s, v[j], at.n);
    for (int i = 0; i < kForms; ++i) subtract_times(s, geometry.form[j][i], at.pairs[i]);
    return s;
  }
};

// All coefficients moving from those of a start to those of one target; values are in the forms.
template <int M>
struct MovingGeometry {
  static constexpr int kOrder = 4;
  const ReducedGeometry& geometry;
  const ReducedPaths& paths;
  C form[kEquations][kForms]{}, slopes[kEquations][M > 0 ? M : 1]{};

  INLINE void load(int, int) {}
  INLINE void go(const V& t) {
    const ReducedLine& line = *paths.line;
    const auto at = [&](const Complex& from, const Complex& change) {
      return C{from.re + t * change.re, from.im + t * change.im};
    };
    for (int j = 0; j < kEquations; ++j) {
      for (int i = 0; i < kForms; ++i) form[j][i] = at(line.form[j][i], line.form_change[j][i]);
      for (int l = 0; l < M; ++l) slopes[j][l] = at(line.slope[j][l], line.slope_change[j][l]);
    }
  }
  INLINE void arrive(int, int) { go(splat(1.0)); }

  INLINE void half_gradient(int j, const C* e, C* half) const {
    const C* c = form[j];
    for (int a = 0; a < 4; ++a) half[a] = C{};
    for (int a = 0, k = 0; a < 4; ++a) {
      add_product(half[a], c[k++], e[a]);
      for (int b = a + 1; b < 4; ++b, ++k) {
        const C entry{0.5 * c[k].re, 0.5 * c[k].im};
        add_product(half[a], entry, e[b]);
        add_product(half[b], entry, e[a]);
      }
    }
  }
  INLINE const C& slope(int j, int l) const { return slopes[j][l]; }
  INLINE C next(int j, int order, const Orders& at) const {
    const ReducedLine& line = *paths.line;
    C s{};
    for (int i = 0; i < kForms; ++i) add_product(s, line.form_change[j][i], at.before[i]);
    for (int l = 0; l < M; ++l) add_product(s, line.slope_change[j][l], at.scalars[l]);
    if (order > 1)
      for (int i = 0; i < kForms; ++i) add_product(s, form[j][i], at.pairs[i]);
    return minus(s);
  }
};

// The same where only values are complex.
template <int M>
struct MovingPlatform {
  static constexpr int kOrder = 3;
  const ReducedGeometry& geometry;
  const ReducedPaths& paths;
  V form[kEquations][kForms]{}, slopes[kEquations][M > 0 ? M : 1]{};
  V v[kEquations]{};  // imaginary parts: the real ones are in the forms

  INLINE void load(int, int) {}
  INLINE void go(const V& t) {
    const ReducedLine& line = *paths.line;
    for (int j = 0; j < kEquations; ++j) {
      for (int i = 0; i < kForms; ++i)
        form[j][i] = line.form[j][i].re + t * line.form_change[j][i].re;
      for (int l = 0; l < M; ++l) slopes[j][l] = line.slope[j][l].re + t * line.slope_change[j][l].re;
      v[j] = line.value[j] + t * line.value_change[j];
    }
  }
  INLINE void arrive(int, int) { go(splat(1.0)); }

  INLINE void half_gradient(int j, const C* e, C* half) const {
    const V* c = form[j];
    for (int a = 0; a < 4; ++a) {
      half[a] = {v[j] * e[a].im, -(v[j] * e[a].re)};
    }
    for (int a = 0, k = 0; a < 4; ++a) {
      add_real(half[a], c[k++], e[a]);
      for (int b = a + 1; b < 4; ++b, ++k) {
        const V entry = 0.5 * c[k];
        add_real(half[a], entry, e[b]);
        add_real(half[b], entry, e[a]);
      }
    }
  }
  INLINE const V& slope(int j, int l) const { return slopes[j][l]; }
  INLINE C next(int j, int order, const Orders& at) const {
    const ReducedLine& line = *paths.line;
    C s{};
    add_times_i(s, splat(line.value_change[j]), at.n_before);
    for (int i = 0; i < kForms; ++i) subtract_times(s, line.form_change[j][i].re, at.before[i]);
    for (int l = 0; l < M; ++l) subtract_times(s, line.slope_change[j][l].re, at.scalars[l]);
    if (order == 1) return s;
    add_times_i(s, v[j], at.n);
    for (int i = 0; i < kForms; ++i) subtract_times(s, form[j][i], at.pairs[i]);
    return s;
  }
};

}  // namespace
}  // namespace gsp
