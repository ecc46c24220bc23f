// The theorem of gspcli.certification.poses.isolation for as many points as there are lanes.
//
// Included by ends.cpp in each of its builds: all in an anonymous namespace, so that the linker cannot merge functions
// that were compiled for different processors.
#pragma once

#include "inverse.hpp"
#include "lanes.hpp"
#include "proofs.hpp"

namespace gsp {
namespace {

// Values and gradients of quadrics, of complex numbers or of bounds of moduli.
template <class T>
struct Quadrics {
  T value[kMostQuadrics];
  T gradient[kMostQuadrics][N];
};

INLINE void add_real(C& s, double a, const C& b) {
  s.re += a * b.re;
  s.im += a * b.im;
}
INLINE void add_real(D& s, double a, const D& b) { s += a * b; }
INLINE void add_term(C& s, const C& a, const C& b) { add_product(s, a, b); }
INLINE void add_term(D& s, const D& a, const D& b) { s += a * b; }
INLINE C half(const C& a) { return {0.5 * a.re, 0.5 * a.im}; }
INLINE D half(const D& a) { return 0.5 * a; }

// The rows of the equations and of their derivatives; the sign of the squares is -1, and 1 for
// bounds of moduli.
template <class T>
void combine(const ProofSystem& system, const Quadrics<T>& q, double sign, T* value,
             T (*jacobian)[N]) {
  value[0] = q.value[1];
  for (int i = 0; i < N; ++i) jacobian[0][i] = q.gradient[1][i];
  for (int r = 0; r < kEquations; ++r) {
    const ProofEquation& e = system.equation[r];
    T* const row = jacobian[r + 1];
    if (e.squares[0] < 0) {
      value[r + 1] = q.value[e.main];
      for (int i = 0; i < N; ++i) row[i] = q.gradient[e.main][i];
      continue;
    }
    T s{};
    add_term(s, q.value[0], q.value[e.main]);
    for (int i = 0; i < N; ++i) {
      row[i] = T{};
      add_term(row[i], q.value[e.main], q.gradient[0][i]);
      add_term(row[i], q.value[0], q.gradient[e.main][i]);
    }
    for (const int b : e.squares) {
      if (b < 0) break;
      T scaled{};
      add_real(scaled, sign, q.value[b]);
      add_term(s, scaled, q.value[b]);
      add_real(scaled, sign, q.value[b]);
      for (int i = 0; i < N; ++i) add_term(row[i], scaled, q.gradient[b][i]);
    }
    value[r + 1] = s;
  }
}

// Radius of the theorem.
constexpr double kReach = 0.125;

template <class T>
void evaluate(int count, const double* hessian, const T* z, Quadrics<T>& out) {
  for (int q = 0; q < count; ++q) {
    T value{};
    for (int i = 0; i < N; ++i) {
      T s{};
      for (int j = 0; j < N; ++j, ++hessian)
        if (*hessian != 0.0) add_real(s, *hessian, z[j]);
      out.gradient[q][i] = s;
      add_term(value, z[i], s);
    }
    out.value[q] = half(value);
  }
}

// The columns of the free coordinates.
template <class T>
INLINE void free_columns(const T* row, const Mask* above, T* out) {
  for (int k = 0; k < kRows; ++k) out[k] = select(above[k], row[k + 1], row[k]);
}

// The theorem is applied to coordinates in units: e in 1, f in a power of two about its largest coordinate, but not
// below one. Where f is large, the columns of the Jacobian matrix would differ by as much.
struct Units {
  D of_f, inverse;

  explicit Units(const C* z) {
    constexpr long long kExponent = 0x7ff0000000000000;
    D largest = D{} + 1.0;
    for (int i = 4; i < N; ++i) largest = maximum(minimum(bound(z[i]), D{} + 0x1p300), largest);
    of_f = (D)((Mask)largest & kExponent), inverse = 1.0 / of_f;
  }
  INLINE D from(int i, const D& x) const { return i < 4 ? x : of_f * x; }
  INLINE C from(int i, const C& x) const { return i < 4 ? x : by(of_f, x); }
  INLINE D into(int i, const D& x) const { return i < 4 ? x : inverse * x; }
};

// Bounds of the sums of the moduli of all second derivatives of each equation where coordinates are
// not larger than m (`System.curvatures`).
void curvatures(const ProofSystem& system, const Units& units, const D* m, D* out) {
  D first[kMostQuadrics], value[kMostQuadrics], second[kMostQuadrics];
  const double* entry = system.moduli;
  for (int q = 0; q < system.quadrics; ++q) {
    first[q] = value[q] = D{};
    // Of e and e, of e and f, of f and f.
    double sums[3] = {};
    for (int i = 0; i < N; ++i) {
      D row = D{};
      for (int j = 0; j < N; ++j, ++entry) {
        row += *entry * m[j];
        sums[(i > 3) + (j > 3)] += *entry;
      }
      first[q] += units.from(i, row);
      value[q] += m[i] * row;
    }
    value[q] = 0.5 * value[q];
    second[q] = sums[0] + units.of_f * (sums[1] + units.of_f * sums[2]);
  }
  out[0] = D{} + second[1];
  for (int r = 0; r < kEquations; ++r) {
    const ProofEquation& e = system.equation[r];
    D s = D{} + second[e.main];
    if (e.squares[0] >= 0) {
      const int a = e.main;
      s = second[0] * value[a] + second[a] * value[0] + 2.0 * (first[0] * first[a]);
      for (const int b : e.squares) {
        if (b < 0) break;
        s += 2.0 * (first[b] * first[b] + second[b] * value[b]);
      }
    }
    out[r + 1] = kOutward * s;
  }
}

// In the free coordinates.
void linearize(const ProofSystem& system, const C* z, const Mask* above, Linear& at) {
  Quadrics<C> quadrics;
  C whole[kRows][N];
  evaluate(system.quadrics, system.hessian, z, quadrics);
  combine(system, quadrics, -1.0, at.value, whole);
  for (int r = 0; r < kRows; ++r) free_columns(whole[r], above, at.jacobian[r]);
  invert(at.jacobian, at.inverse);
}

// Bounds of the distance of a solution from a point, and from the point after a step of Newton's
// method.
struct Isolation {
  D error, error_after;
  Mask isolated, real, imaginary;
};

// Whether there is exactly one solution near a point, from the equations there. Their values err by
// `rounding` times the sum of the moduli of their terms, and by `gap` times N (6).
void isolate(const ProofSystem& system, const Units& units, const C* z, const Mask* above, const Linear& at,
             double value_rounding, const D* gap, Isolation& out) {
  Quadrics<D> bounds;
  D m[N], value_bound[kRows], whole_bound[kRows][N], curvature[kRows];
  for (int i = 0; i < N; ++i) m[i] = bound(z[i]);
  evaluate(system.quadrics, system.moduli, m, bounds);
  combine(system, bounds, 1.0, value_bound, whole_bound);
  D height = D{};
  for (int i = 0; i < N; ++i) height = maximum(height, units.into(i, size_of(z[i].im)));
  for (int i = 0; i < N; ++i) m[i] = kOutward * (m[i] + units.from(i, D{} + kReach));
  curvatures(system, units, m, curvature);
  // For each row: the effect of rounding on the product of the inverse with it, and on its value.
  D rounding[kRows], size[kRows], doubt[kRows];
  for (int j = 0; j < kRows; ++j) {
    D row_bound[kRows];
    for (int i = 0; i < N; ++i) whole_bound[j][i] = units.from(i, whole_bound[j][i]);
    free_columns(whole_bound[j], above, row_bound);
    D s = D{};
    for (int k = 0; k < kRows; ++k) s += bound(at.jacobian[j][k]) + kOutward * row_bound[k];
    rounding[j] = kRounding * s;
    doubt[j] = value_rounding * kOutward * value_bound[j] + kTiny;
    if (j > 0) doubt[j] += gap[j - 1] * kOutward * bounds.value[0];
    size[j] = bound(at.value[j]) + doubt[j];
    doubt[j] += kStepRounding * size[j];
  }
  D a = D{}, b = D{}, delta = D{}, left = D{}, sum = D{};
  for (int i = 0; i < kRows; ++i) {
    D defect = D{}, bent = D{}, doubtful = D{};
    C step{splat(0.0), splat(0.0)};
    for (int k = 0; k < kRows; ++k) {
      C s{splat(i == k ? 1.0 : 0.0), splat(0.0)};
      for (int j = 0; j < kRows; ++j) subtract_product(s, at.inverse[i][j], at.jacobian[j][k]);
      defect += bound(s);
    }
    for (int j = 0; j < kRows; ++j) {
      const D y = bound(at.inverse[i][j]);
      defect += y * rounding[j];
      bent += y * curvature[j];
      doubtful += y * doubt[j];
      add_product(step, at.inverse[i][j], at.value[j]);
    }
    // Its terms cancel where the inverse is large.
    const D moved = bound(step) + doubtful;
    a = maximum(defect, a);
    b = maximum(bent, b);
    delta = maximum(moved, delta);
    left = maximum(doubtful, left);
    sum += defect + bent + moved;
  }
  a = kOutward * a + kTiny;
  b = kOutward * b;
  delta = kOutward * delta;
  const D radius = minimum((1.0 - a) / (2.0 * b), D{} + kReach);
  const D q = kOutward * (a + b * radius);
  // A NaN is part of the sum, so that it proves nothing.
  out.isolated = (sum < __builtin_inf()) & (q < 1.0) & (radius > 0.0) &
                 (kOutward * delta <= (1.0 - q) * radius);
  out.error = kOutward * (delta / (1.0 - q));
  out.error_after = kOutward * ((a + b * out.error) * out.error + left);
  out.real = out.isolated & (kOutward * (2.0 * height + out.error) <= radius);
  out.imaginary = out.isolated & (height > kOutward * out.error);
}

}  // namespace
}  // namespace gsp
