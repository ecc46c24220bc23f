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

// Values of equations whose quadrics are those of distances and cosines of zero, one set in each lane.
struct LaneValues {
  D norm[kEquations], bound[kEquations];  // how often N is added to the main quadric; of the moduli of that
  D distance[kEquations];                 // what quadrics are multiplied by, and with `parts` their moduli
  double parts;
  const std::int32_t* turned;  // (6) which: -1: none
};

// Equations that have their values in their quadrics, or in lanes.
struct LaneSystem : ProofSystem {
  const LaneValues* values;
  LaneSystem(const ProofSystem& system, const LaneValues* in_lanes = nullptr) : ProofSystem(system), values(in_lanes) {}
};

INLINE void add_values(const LaneSystem& system, const C* z, Quadrics<C>& q) {
  const LaneValues& v = *system.values;
  for (int r = 0; r < kEquations; ++r) {
    const int main = system.equation[r].main, turned = v.turned[r];
    q.value[main] = q.value[main] + by(v.norm[r], q.value[0]);
    for (int i = 0; i < 4; ++i) q.gradient[main][i] = q.gradient[main][i] + by(2.0 * v.norm[r], z[i]);
    if (turned < 0) continue;
    q.value[turned] = by(v.distance[r], q.value[turned]);
    for (int i = 0; i < N; ++i) q.gradient[turned][i] = by(v.distance[r], q.gradient[turned][i]);
  }
}

// The same of bounds.
INLINE void add_bounds(const LaneSystem& system, const D* m, Quadrics<D>& q) {
  const LaneValues& v = *system.values;
  for (int r = 0; r < kEquations; ++r) {
    const int main = system.equation[r].main, turned = v.turned[r];
    for (int i = 0; i < 4; ++i) {
      q.value[main] += v.bound[r] * m[i] * m[i];
      q.gradient[main][i] += 2.0 * v.bound[r] * m[i];
    }
    if (turned < 0) continue;
    const D factor = v.parts * v.distance[r];
    q.value[turned] *= factor;
    for (int i = 0; i < N; ++i) q.gradient[turned][i] *= factor;
  }
}

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
void curvatures(const LaneSystem& system, const Units& units, const D* m, D* out) {
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
  for (int r = 0; system.values && r < kEquations; ++r) {
    const LaneValues& v = *system.values;
    const int main = system.equation[r].main, turned = v.turned[r];
    for (int i = 0; i < 4; ++i) first[main] += 2.0 * v.bound[r] * m[i], value[main] += v.bound[r] * m[i] * m[i];
    second[main] += 8.0 * v.bound[r];
    if (turned < 0) continue;
    const D factor = v.parts * v.distance[r];
    first[turned] *= factor, value[turned] *= factor, second[turned] *= factor;
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
void evaluate(const LaneSystem& system, const C* z, const Mask* above, Linear& at) {
  Quadrics<C> quadrics;
  C whole[kRows][N];
  evaluate(system.quadrics, system.hessian, z, quadrics);
  if (system.values) add_values(system, z, quadrics);
  combine(system, quadrics, -1.0, at.value, whole);
  for (int r = 0; r < kRows; ++r) free_columns(whole[r], above, at.jacobian[r]);
}

void linearize(const LaneSystem& system, const C* z, const Mask* above, Linear& at) {
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
void isolate(const LaneSystem& system, const Units& units, const C* z, const Mask* above, const Linear& at,
             double value_rounding, const D* gap, Isolation& out) {
  Quadrics<D> bounds;
  D m[N], value_bound[kRows], whole_bound[kRows][N], curvature[kRows];
  for (int i = 0; i < N; ++i) m[i] = bound(z[i]);
  evaluate(system.quadrics, system.moduli, m, bounds);
  if (system.values) add_bounds(system, m, bounds);
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
