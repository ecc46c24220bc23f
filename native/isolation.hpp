// The theorem of gspcli.certification.poses.isolation for as many points as there are lanes.
//
// Included by ends.cpp and by finer_ends.cpp (with 32 digits) in each of their builds: all in an anonymous namespace, so
// that the linker cannot merge functions that were compiled for different processors.
#pragma once

#include "combined_quadrics.hpp"
#include "inverse.hpp"

namespace gsp {
namespace {

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

// With 32 digits each coordinate has a unit, a power of two: the theorem is applied to the coordinates in units.
#if GSP_PARTS == 1
struct Units {
  INLINE D from(int, const D& x) const { return x; }
  INLINE D into(int, const D& x) const { return x; }
  INLINE double product(int, int, double x) const { return x; }
};
typedef double Second;
#else
struct Units {
  D unit[N], inverse[N];
  INLINE D from(int i, const D& x) const { return unit[i] * x; }
  INLINE D into(int i, const D& x) const { return inverse[i] * x; }
  INLINE D product(int i, int j, double x) const { return x * (unit[i] * unit[j]); }
};
typedef D Second;
#endif

// Bounds of the sums of the moduli of all second derivatives of each equation where coordinates are
// not larger than m (`System.curvatures`).
void curvatures(const ProofSystem& system, const Units& units, const D* m, D* out) {
  D first[kMostQuadrics], value[kMostQuadrics];
  Second second[kMostQuadrics];
  const double* entry = system.moduli;
  for (int q = 0; q < system.quadrics; ++q) {
    first[q] = value[q] = D{};
    second[q] = Second{};
    for (int i = 0; i < N; ++i) {
      D row = D{};
      Second sum{};
      for (int j = 0; j < N; ++j, ++entry) {
        row += *entry * m[j];
        sum += units.product(i, j, *entry);
      }
      first[q] += units.from(i, row);
      value[q] += m[i] * row;
      second[q] += sum;
    }
    value[q] = 0.5 * value[q];
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

// The equations at a point: values and derivatives by the free coordinates, with an approximate inverse
// there or near there.
struct Linear {
  C value[kRows], jacobian[kRows][kRows], inverse[kRows][kRows];
};

#if GSP_PARTS == 1
void evaluate(const ProofSystem& system, const C* z, const Mask* above, Linear& at) {
  Quadrics<C> quadrics;
  C whole[kRows][N];
  evaluate(system.quadrics, system.hessian, z, quadrics);
  combine(system, quadrics, -1.0, at.value, whole);
  for (int r = 0; r < kRows; ++r) free_columns(whole[r], above, at.jacobian[r]);
}

void linearize(const ProofSystem& system, const C* z, const Mask* above, Linear& at) {
  evaluate(system, z, above, at);
  invert(at.jacobian, at.inverse);
}
#endif

// The step of Newton's method, in the free coordinates.
INLINE void newton_step(const Linear& at, C* change) {
  for (int i = 0; i < kRows; ++i) {
    change[i] = C{};
    for (int j = 0; j < kRows; ++j) add_product(change[i], at.inverse[i][j], at.value[j]);
  }
}

// Bounds of the distance of a solution from a point, and from the point after a step of Newton's
// method.
struct Isolation {
  D error, error_after;
  Mask isolated, real, imaginary;
};
// Relative error of that step where nothing cancels.
constexpr double kStepRounding = GSP_PARTS == 1 ? 0x1p-48 : 0x1p-90;

// Whether there is exactly one solution near a point, from the equations there. Their values err by
// `rounding` times the sum of the moduli of their terms, and by `gap` times N (6).
void isolate(const ProofSystem& system, const Units& units, const C* z, const Mask* above, const Linear& at,
             double value_rounding, const double* gap, Isolation& out) {
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
