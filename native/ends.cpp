#include "ends.hpp"

#include "isolation.hpp"

namespace gsp {
namespace {

// Errors of a coefficient plus a weight times a value (`many_values`): those of coefficient, weight,
// value, their product and the sum.
constexpr double kParts = 4.0;
constexpr int kNewtonSteps = 1, kCloseSteps = 3;  // paths have had theirs
constexpr double kCloseRounding = 0x1p-90;        // of values with 32 digits
constexpr int kEntries = 12;  // of R and of T
constexpr double kNothing = 5e-10;  // rounds to zero to nine digits

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

// N, N R by rows, N T (`study.motion`).
void motion(const C* z, C& norm, C* entry) {
  const C *e = z, *f = z + 4;
  C p[4][4];
  for (int i = 0; i < 4; ++i)
    for (int j = i; j < 4; ++j) p[i][j] = p[j][i] = e[i] * e[j];
  norm = p[0][0] + p[1][1] + p[2][2] + p[3][3];
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    entry[4 * i] = p[0][0] + p[i + 1][i + 1] - p[j + 1][j + 1] - p[k + 1][k + 1];
    const C skew = p[0][k + 1] + p[0][k + 1], even = p[i + 1][j + 1] + p[i + 1][j + 1];
    entry[3 * i + j] = even - skew;
    entry[3 * j + i] = even + skew;
    C t{};  // of f times the conjugate of e
    add_product(t, f[i + 1], e[0]);
    subtract_product(t, f[0], e[i + 1]);
    subtract_product(t, f[j + 1], e[k + 1]);
    add_product(t, f[k + 1], e[j + 1]);
    entry[9 + i] = t + t;
  }
}

// A square root of a complex number that is not negative.
INLINE C complex_root(const C& z) {
  const V size = root(square(z));
  const V re = root(0.5 * maximum(size + z.re, splat(0.0)));
  const V other = root(0.5 * maximum(size - z.re, splat(0.0)));
  const Mask right = z.re > 0.0;
  const V tiny = splat(kTiny);
  const V im = select(z.im < 0.0, -other, other);
  return {select(right, re, 0.5 * maximum(z.im, -z.im) / (other + tiny)),
          select(right, 0.5 * z.im / (re + tiny), im)};
}

// The poses of points that are known up to an error, and how far they are from the solutions
// (`floating.deviations`).
V deviate(const C* z, const V& error, const C& norm, C* entry) {
  V turning = splat(0.0), moving = splat(0.0);
  for (int i = 0; i < 4; ++i) turning += bound(z[i]);
  for (int i = 0; i < N; ++i) moving += bound(z[i]);
  turning = 2.0 * turning * error + 8.0 * error * error + kRounding * turning * turning;
  moving = 2.0 * moving * error + 8.0 * error * error + kRounding * moving * moving;
  const V size = root(square(norm));
  const V least = (1.0 - kRounding) * size - kOutward * turning;
  const V inverse = 1.0 / (size * size);
  const C factor{inverse * norm.re, -(inverse * norm.im)};
  V worst = splat(0.0);
  for (int i = 0; i < kEntries; ++i) {
    entry[i] = factor * entry[i];
    const V change = i < 9 ? turning : moving;
    worst = maximum((change + bound(entry[i]) * (turning + kRounding * size)) / least, worst);
  }
  return select(least > 0.0, kOutward * worst, splat(__builtin_inf()));
}

// hi + low -= change
INLINE void subtract(V& hi, V& low, const V& change) {
  const V t = low - change, s = hi + t, v = s - hi;
  low = (hi - (s - v)) + (t - v);
  hi = s;
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

// The linear form of `distinct`, and how far it can be off.
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
  C entry[kEntries], quaternion[4];
  V deviation, low, high;
  Isolation found;
};

// The poses of proved points, and how far they are off.
void measure(const OpenGeometry& open, C* z, Lanes& s) {
  // The real part is no further from a real solution.
  for (int i = 0; i < N; ++i) z[i].im = select(s.found.real, splat(0.0), z[i].im);
  C norm;
  motion(z, norm, s.entry);
  s.deviation = deviate(z, s.found.error, norm, s.entry);
  V largest = splat(1.0);
  for (int i = 0; i < kEntries; ++i) largest = maximum(largest, root(square(s.entry[i])));
  const Mask known = s.found.isolated & (s.deviation <= open.tolerance * largest);
  s.found.isolated = known;
  s.found.real = s.found.real & known;
  s.found.imaginary = s.found.imaginary & known;
  V middle, reach;
  form(s.entry, s.deviation, middle, reach);
  s.low = middle - reach, s.high = middle + reach;
  const C length = complex_root(norm);
  const V inverse = 1.0 / square(length);
  const C factor{inverse * length.re, -(inverse * length.im)};
  // The first part that is not zero to nine digits is positive (`quaternions.canonical_sign`).
  V sign = splat(1.0);
  for (int i = 4; i-- > 0;) {
    s.quaternion[i] = factor * z[i];
    const V parts[] = {s.quaternion[i].im, s.quaternion[i].re};
    for (const V& part : parts) {
      sign = select(part > kNothing, splat(1.0), sign);
      sign = select(part < -kNothing, splat(-1.0), sign);
    }
  }
  for (int i = 0; i < 4; ++i) s.quaternion[i] = sign * s.quaternion[i];
  for (int i = 9; i < kEntries; ++i) s.entry[i] = splat(open.scale) * s.entry[i];
}

// What is to be done for one set of values.
struct Decision {
  const OpenGeometry& open;
  const OpenValues& given;
  const Complex* points;
  const Poses& out;
  ProofSystem system;
  double *low, *high;  // ends of the intervals of the linear form
  double* work;        // for residuals
};

// In double precision.
void decide_quickly(const Decision& d, C* z, const Mask* above, const Mask* below, Lanes& s) {
  prove_lanes(d.system, kNewtonSteps, z, above, below, s.found);
}

// With values of 32 digits, at points that have a lower part.
void decide_closely(const Decision& d, int count, C* z, const Mask* above, const Mask* below,
                    Lanes& s) {
  const FineGeometry fine{d.open.equations.quadrics, d.open.equations.hessian, d.open.hessian_low,
                          d.open.weight, d.open.weight_low, d.open.turned,
                          d.open.equations.equation};
  const FineValues values{d.given.value, d.given.low, d.given.distance,
                          d.given.distance_low};
  double gap[kEquations];
  for (int r = 0; r < kEquations; ++r) gap[r] = kOutward * d.open.weight_bound[r] * d.given.gap[r];
  C low[N] = {};
  Linear at;
  for (int step = 0;; ++step) {
    Complex point[W * N], rest[W * N], value[W * kRows];
    for (int l = 0; l < W; ++l)
      for (int i = 0; i < N; ++i) {
        point[l * N + i] = lane(z[i], l);
        rest[l * N + i] = lane(low[i], l);
      }
    GSP_RESIDUALS(fine, values, count, point, rest, d.work, value);
    linearize(d.system, z, above, at);
    for (int r = 0; r < kRows; ++r)
      for (int l = 0; l < W; ++l) put(at.value[r], l, value[(l < count ? l : 0) * kRows + r]);
    if (step == kCloseSteps) break;
    C change[kRows];
    newton_step(at, change);
    for (int k = 0; k < N; ++k) {
      const C none{};
      C moved = k < kRows ? select(below[k], change[k], none) : none;
      if (k > 0) moved = moved + select(above[k - 1], change[k - 1], none);
      subtract(z[k].re, low[k].re, moved.re);
      subtract(z[k].im, low[k].im, moved.im);
    }
  }
  isolate(d.system, z, above, at, kCloseRounding, gap, s.found);
}

// Points by their indices, as many as there are lanes; returns which are proved, one bit each.
unsigned decide_lanes(const Decision& d, int count, const int* index, bool closely) {
  C z[N];
  // Lanes that are left over repeat the first point.
  for (int l = 0; l < W; ++l)
    for (int i = 0; i < N; ++i) put(z[i], l, d.points[N * index[l < count ? l : 0] + i]);
  V patch;
  place(d.open, z, patch);
  Mask above[kRows], below[kRows];
  for (int k = 0; k < kRows; ++k) {
    above[k] = patch <= splat(k);
    below[k] = ~above[k];
  }
  Lanes s;
  if (closely) decide_closely(d, count, z, above, below, s);
  else decide_quickly(d, z, above, below, s);
  measure(d.open, z, s);
  unsigned done = 0;
  for (int l = 0; l < count; ++l) {
    const int p = index[l];
    const Poses& out = d.out;
    for (int i = 0; i < 9; ++i) out.rotation[9 * p + i] = lane(s.entry[i], l);
    for (int i = 0; i < 3; ++i) out.translation[3 * p + i] = lane(s.entry[9 + i], l);
    for (int i = 0; i < 4; ++i) out.quaternion[4 * p + i] = lane(s.quaternion[i], l);
    out.deviation[p] = lane(s.deviation, l);
    d.low[p] = lane(s.low, l), d.high[p] = lane(s.high, l);
    out.proved[p] = static_cast<std::uint8_t>((s.found.isolated[l] ? kIsolated : 0) |
                                              (s.found.real[l] ? kReal : 0) |
                                              (s.found.imaginary[l] ? kComplex : 0));
    if (s.found.real[l] || s.found.imaginary[l]) done |= 1u << l;
  }
  return done;
}

// Returns how many of the points in the list are not proved; these are its first then.
int decide_all(const Decision& d, int count, double* list, bool closely) {
  int left = 0;
  for (int begin = 0; begin < count; begin += W) {
    int index[W];
    const int size = count - begin < W ? count - begin : W;
    for (int l = 0; l < size; ++l) index[l] = static_cast<int>(list[begin + l]);
    const unsigned done = decide_lanes(d, size, index, closely);
    for (int l = 0; l < size; ++l)
      if (!(done >> l & 1)) list[left++] = index[l];
  }
  return left;
}

void decide(const OpenGeometry& open, const OpenValues& given, int count, const Complex* points,
            double* work, const Poses& out) {
  const int size = open.equations.quadrics * N * N;
  double *const hessian = work, *const moduli = hessian + size, *const fine = moduli + size;
  double *const low = fine + 2 * size, *const high = low + count, *const list = high + count;
  insert(open, given, hessian, moduli);
  const Decision d{open, given, points, out,
                   {open.equations.quadrics, hessian, moduli, open.equations.equation}, low, high, fine};
  for (int p = 0; p < count; ++p) list[p] = p;
  int left = decide_all(d, count, list, false);
  // What does not even exist is not looked at again.
  int there = 0;
  for (int k = 0; k < left; ++k)
    if (points[N * static_cast<int>(list[k])].re == points[N * static_cast<int>(list[k])].re)
      list[there++] = list[k];
  if (there > 0) left += decide_all(d, there, list, true) - there;
  *out.complete = left == 0 && different(count, low, high, list);
}

}  // namespace

void GSP_DECIDE(const OpenGeometry& open, const OpenValues& given, int count,
                const Complex* points, double* work, const Poses& poses) {
  decide(open, given, count, points, work, poses);
}

}  // namespace gsp
