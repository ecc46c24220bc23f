#include "ends.hpp"

#include "isolation.hpp"
#include "shared_lanes.hpp"

namespace gsp {
namespace {

// Errors of a coefficient plus a weight times a value (`many_values`): the errors of coefficient,
// weight, value, their product and the sum.
constexpr double kParts = 4.0;
constexpr int kSteps = 0, kMoreSteps = 3;      // before the proof: paths have had theirs
constexpr double kValueRounding = 0x1p-94;     // of values with 32 digits (FinePoints)
constexpr int kEntries = 12, kNumbers = 16;    // of R and of T; and with the quaternion

// The Hessian matrices and moduli for one set of values.
void insert(const OpenGeometry& open, const OpenValues& given, double* hessian, double* moduli) {
  const ProofSystem& base = open.equations;
  const int size = base.quadrics * N * N;
  for (int i = 0; i < size; ++i) hessian[i] = base.hessian[i], moduli[i] = base.moduli[i];
  for (int r = 0; r < kEquations; ++r) {
    const int main = base.equation[r].main * N * N, turned = open.turned[r] * N * N;
    const double bound = kParts * (open.norm_bound[r] + open.weight_bound[r] * given.bound[r]);
    for (int i = 0; i < 4; ++i) {
      hessian[main + i * (N + 1)] += 2.0 * open.weight[r] * given.value[r];
      moduli[main + i * (N + 1)] += 2.0 * bound;
    }
    if (turned < 0) continue;
    for (int i = 0; i < N * N; ++i) {
      hessian[turned + i] *= given.distance[r];
      moduli[turned + i] *= kParts * given.distance[r];
    }
  }
}

// p += c a b as quaternions, a or b without real part and real.
INLINE void add_turned(C* p, double c, const double* a, const C* b) {
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    add_real(p[0], -c * a[i], b[i + 1]);
    add_real(p[i + 1], c * a[i], b[0]);
    add_real(p[i + 1], c * a[j], b[k + 1]);
    add_real(p[i + 1], -c * a[k], b[j + 1]);
  }
}
INLINE void add_turned(C* p, double c, const C* a, const double* b) {
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    add_real(p[0], -c * b[i], a[i + 1]);
    add_real(p[i + 1], c * b[i], a[0]);
    add_real(p[i + 1], c * b[k], a[j + 1]);
    add_real(p[i + 1], -c * b[j], a[k + 1]);
  }
}

// From the points' own frames to those of the equations, where the largest coordinate of e is 1.
void place(const OpenGeometry& open, C* z, V& patch) {
  C f[4] = {};
  for (int i = 0; i < 4; ++i) add_real(f[i], open.unit, z[4 + i]);
  add_turned(f, 0.5, open.base, z);
  add_turned(f, -0.5, z, open.platform);
  C largest = z[0];
  V size = square(z[0]);
  patch = splat(0.0);
  for (int i = 1; i < 4; ++i) {
    const Mask more = square(z[i]) > size;
    largest = select(more, z[i], largest);
    patch = select(more, splat(i), patch);
    size = maximum(size, square(z[i]));
  }
  const V inverse = 1.0 / size;
  const C factor{inverse * largest.re, -(inverse * largest.im)};
  for (int i = 0; i < 4; ++i) {
    z[4 + i] = factor * f[i];
    const Mask here = patch == splat(i);
    z[i] = select(here, C{splat(1.0), splat(0.0)}, factor * z[i]);
  }
}

// Which of the points are in order by their keys (Shell's method).
void sort(int count, const double* key, double* index) {
  for (int i = 0; i < count; ++i) index[i] = i;
  for (int gap = count / 2; gap > 0; gap /= 2)
    for (int i = gap; i < count; ++i) {
      const double moved = index[i];
      int j = i;
      for (; j >= gap && key[static_cast<int>(index[j - gap])] > key[static_cast<int>(moved)]; j -= gap)
        index[j] = index[j - gap];
      index[j] = moved;
    }
}

// Whether a linear form proves that all poses are different: intervals in the order of their lower
// ends, none of which reaches the next.
bool different(int count, const double* low, const double* high, double* index) {
  sort(count, low, index);
  for (int i = 1; i < count; ++i)
    if (!(high[static_cast<int>(index[i - 1])] < low[static_cast<int>(index[i])])) return false;
  return true;
}

// The linear form of `distinct`, and a bound of its error.
void form(const C* entry, const V& deviation, V& middle, V& reach) {
  middle = reach = splat(0.0);
  double total = 0.0;
  for (int i = 0; i < 2 * kEntries; ++i) {
    double weight = (i + 1) * 0.6180339887498949;
    weight -= static_cast<int>(weight);
    const V part = i < kEntries ? entry[i].re : entry[i - kEntries].im;
    middle += weight * part;
    reach += weight * maximum(part, -part);
    total += weight;
  }
  reach = kOutward * (total * deviation + (kOutward - 1.0) * reach);
}

struct Lanes {
  C entry[kNumbers];
  V deviation, low, high, f_unit;  // of the errors of f
  Mask rounded;
  Isolation found;
};

// What is to be done for one set of values.
struct Decision {
  const OpenGeometry& open;
  const OpenValues& given;
  int count;  // of points of each set
  const Complex* points;
  const Poses& out;
  ProofSystem system;
  const double *high_coefficients, *low_coefficients;
  double *low, *high;  // ends of the intervals of the linear form
};

// A point of 32 digits with its monomials, and how it moves in a step of Newton's method.
struct FinePoint {
  Shared<N> high, low, change;
  Shared<kMonomials> monomials, monomials_low;
};

// The poses of proved points, and bounds of their errors.
void measure(const Decision& d, FinePoint& point, Lanes& s) {
  const OpenGeometry& open = d.open;
  Shared<kNumbers> entry;
  double error[W], f_unit[W], real[W], unit[W], deviation[W], rounded[W];
  for (int l = 0; l < W; ++l)
    unit[l] = d.given.unit, error[l] = s.found.error_after[l], f_unit[l] = s.f_unit[l], real[l] = s.found.real[l] ? 1.0 : 0.0;
  GSP_FINE.poses({point.high, point.low}, {point.monomials, point.monomials_low}, point.change, error, f_unit, real,
                 unit, {entry, deviation, rounded});
  entry.load(s.entry);
  for (int l = 0; l < W; ++l) s.deviation[l] = deviation[l], s.rounded[l] = rounded[l] != 0.0 ? -1 : 0;
  V largest = splat(1.0);
  for (int i = 0; i < kEntries; ++i) largest = maximum(largest, root(square(s.entry[i])));
  const Mask known = s.found.isolated & (s.deviation <= open.tolerance * largest);
  s.found.isolated = known;
  s.found.real = s.found.real & known;
  s.found.imaginary = s.found.imaginary & known;
  s.rounded = s.rounded & known;
  V middle, reach;
  form(s.entry, s.deviation, middle, reach);
  s.low = middle - reach, s.high = middle + reach;
  for (int i = 9; i < kEntries; ++i) s.entry[i] = splat(open.scale) * s.entry[i];
}

// Whether solutions are near points, after so many steps of Newton's method; returns the unit of the errors of f.
V prove_points(const Decision& d, int steps, const Mask* above, const Mask* below, C* z,
               FinePoint& point, Isolation& found) {
  Linear at;
  C low[N] = {};
  for (int step = 0;; ++step) {
    Shared<kRows> value;
    C change[kRows], moved[N];
    linearize(d.system, z, above, at);
    point.high.store(z), point.low.store(low);
    GSP_FINE.values(d.system.quadrics, d.system.equation, d.high_coefficients, d.low_coefficients,
                    {point.high, point.low}, {point.monomials, point.monomials_low}, value);
    value.load(at.value);
    newton_step(at, change);
    // Free coordinate k is coordinate k below the patch, k + 1 above it.
    const C none{};
    for (int k = 0; k < N; ++k) {
      moved[k] = k < kRows ? select(below[k], change[k], none) : none;
      if (k > 0) moved[k] = moved[k] + select(above[k - 1], change[k - 1], none);
    }
    point.change.store(moved);
    if (step == steps) break;
    for (int k = 0; k < N; ++k) {
      subtract(z[k].re, low[k].re, moved[k].re);
      subtract(z[k].im, low[k].im, moved[k].im);
    }
  }
  const Units units(z);
  for (int r = 0; r < kRows; ++r)
    for (int k = kRows - 4; k < kRows; ++k) {
      at.jacobian[r][k] = by(units.of_f, at.jacobian[r][k]);
      at.inverse[k][r] = by(units.inverse, at.inverse[k][r]);
    }
  V gap[kEquations];
  for (int r = 0; r < kEquations; ++r) gap[r] = splat(kOutward * d.open.weight_bound[r] * d.given.gap[r]);
  isolate(d.system, units, z, above, at, kValueRounding, gap, found);
  return units.of_f;
}

// Points by their indices in all lanes, of which so many count; returns which are proved and rounded, one bit each.
unsigned decide_lanes(const Decision& d, int count, const int* index, int steps) {
  C z[N];
  for (int l = 0; l < W; ++l)
    for (int i = 0; i < N; ++i) put(z[i], l, d.points[N * index[l] + i]);
  V patch;
  place(d.open, z, patch);
  Mask above[kRows], below[kRows];
  for (int k = 0; k < kRows; ++k) {
    above[k] = patch <= splat(k);
    below[k] = ~above[k];
  }
  Lanes s;
  FinePoint point;
  s.f_unit = prove_points(d, steps, above, below, z, point, s.found);
  measure(d, point, s);
  unsigned done = 0;
  for (int l = 0; l < count; ++l) {
    const int p = index[l];
    const Poses& out = d.out;
    for (int i = 0; i < 9; ++i) out.rotation[9 * p + i] = lane(s.entry[i], l);
    for (int i = 0; i < 3; ++i) out.translation[3 * p + i] = lane(s.entry[9 + i], l);
    for (int i = 0; i < 4; ++i) out.quaternion[4 * p + i] = lane(s.entry[kEntries + i], l);
    out.deviation[p] = lane(s.deviation, l);
    d.low[p] = lane(s.low, l), d.high[p] = lane(s.high, l);
    const bool decided = s.found.real[l] || s.found.imaginary[l];
    out.proved[p] = static_cast<std::uint8_t>(
        (s.found.isolated[l] ? kIsolated : 0) | (s.found.real[l] ? kReal : 0) |
        (s.found.imaginary[l] ? kComplex : 0) | (s.rounded[l] ? kRounded : 0));
    if (decided && s.rounded[l]) done |= 1u << l;
  }
  return done;
}

// Returns how many of the points in the list are not proved and rounded; these are its first then.
int decide_all(const Decision& d, int count, double* list, int steps) {
  int left = 0;
  for (int begin = 0; begin < count; begin += W) {
    int index[W];
    const int size = count - begin < W ? count - begin : W;
    // Lanes without a point repeat the first one.
    for (int l = 0; l < W; ++l) index[l] = static_cast<int>(list[begin + (l < size ? l : 0)]);
    const unsigned done = decide_lanes(d, size, index, steps);
    for (int l = 0; l < size; ++l)
      if (!(done >> l & 1)) list[left++] = index[l];
  }
  return left;
}

// Of points in a list those that are numbers: they are its first then.
int there(const Complex* points, int count, double* list) {
  int found = 0;
  for (int k = 0; k < count; ++k) {
    const double re = points[N * static_cast<int>(list[k])].re;
    if (re == re) list[found++] = list[k];
  }
  return found;
}

}  // namespace

void GSP_DECIDE(const OpenGeometry& open, const OpenValues& given, int count, const Complex* points, double* work,
                const Poses& out) {
  const int quadrics = open.equations.quadrics, size = quadrics * N * N, fine = quadrics * kMonomials;
  double *const hessian = work, *const moduli = hessian + size, *const coefficients = moduli + size;
  double *const low = coefficients + 2 * fine, *const high = low + count, *const list = high + count;
  insert(open, given, hessian, moduli);
  GSP_FINE.coefficients({quadrics, open.equations.hessian, open.hessian_low, open.weight, open.weight_low,
                         open.turned, open.equations.equation},
                        {given.value, given.low, given.distance, given.distance_low}, coefficients,
                        coefficients + fine);
  const Decision d{open, given, count, points, out, {quadrics, hessian, moduli, open.equations.equation},
                   coefficients, coefficients + fine, low, high};
  for (int p = 0; p < count; ++p) list[p] = p;
  const int left = there(points, decide_all(d, count, list, kSteps), list);
  if (left > 0) decide_all(d, left, list, kMoreSteps);
  bool all = true;
  for (int p = 0; p < count; ++p) all = all && (out.proved[p] & (kReal | kComplex));
  *out.complete = all && different(count, low, high, list);
}

}  // namespace gsp
