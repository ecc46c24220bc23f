#include "far_equations.hpp"
#include "shared_lanes.hpp"

namespace gsp {
namespace {

// Paths of poses far away in their local coordinates, in lanes: along a line between two shifts of the values.
//
// Two such poses may be near each other, and come together where values change. From complex values in general
// position no two do on the way to real ones.

constexpr double kFirstStep = 0.125, kLeastStep = 0x1p-14;
// The second step of Newton's method after a prediction is at most such a part of the first: then the other
// solutions are many times as far away as the prediction is off. After a much smaller one steps grow.
constexpr double kCertainly = 1.0 / 16, kEasily = 1.0 / 512;
// Of values in doubles, as a part of the moduli of their terms. Where a step may be longer than such a part of the
// coordinates (or of kLeastSize, if they are smaller), digits are lost, and nothing is found.
constexpr double kNoise = 0x1p-48, kLostDigits = 1e-4, kLeastSize = 1e-3;

struct Tangent {
  C at[kRows], along[kRows];
};

INLINE V largest(const C* x) {
  V most = splat(0.0);
  for (int i = 0; i < kRows; ++i) most = maximum(most, bound(x[i]));
  return most;
}

INLINE bool any(const Mask& m) {
  for (int l = 0; l < W; ++l)
    if (m[l]) return true;
  return false;
}

// How long a step of Newton's method may be because of rounding.
INLINE V noise(const Block& b, const C* shift, const C* s, const Linear& at) {
  V size[kRows], terms[kRows], most = splat(0.0);
  for (int i = 0; i < kRows; ++i) size[i] = bound(s[i]);
  const V norm = sizes_of(b, kOfNorm * kLocalMonomials, size).value;
  for (int r = 0; r < kRows; ++r) {
    terms[r] = sizes_of(b, r * kLocalMonomials, size).value;
    V by = bound(shift[r]) * norm;
    if (b.second[r]) {
      terms[r] *= sizes_of(b, b.second[r], size).value;
      by = (by + bound(b.number(b.second[r] + kConstant)) * norm) * norm;
    }
    terms[r] += by;
  }
  for (int i = 0; i < kRows; ++i) {
    V sum = splat(0.0);
    for (int r = 0; r < kRows; ++r) sum += bound(at.inverse[i][r]) * terms[r];
    most = maximum(most, sum);
  }
  return splat(kNoise) * most;
}

// How local coordinates change with a shift, from the equations there and N.
INLINE void differentiate_by_shift(const Block& b, const Linear& at, const C& norm, const C* change, C* along) {
  C by[kRows];
  for (int r = 0; r < kRows; ++r) by[r] = b.second[r] ? norm * change[r] : change[r];
  for (int i = 0; i < kRows; ++i) {
    along[i] = C{};
    for (int r = 0; r < kRows; ++r) add_product(along[i], by[r], at.inverse[i][r]);
    along[i] = norm * along[i];
  }
}

// Follows local coordinates in all lanes between two shifts of the equations, with steps of their own. In lanes where
// steps become too small the coordinates are not changed; returns the others.
Mask follow_line(const Block& b, const C* from, const C* to, C* s) {
  C change[kRows], here[kRows];
  for (int r = 0; r < kRows; ++r) change[r] = to[r] - from[r];
  Linear at;
  Tangent now, last;
  C norm = linearize(b, from, s, at), first[kRows], second[kRows];
  differentiate_by_shift(b, at, norm, change, now.along);
  for (int i = 0; i < kRows; ++i) now.at[i] = s[i];
  last = now;
  V done = splat(0.0), step = splat(kFirstStep), before = splat(0.0);
  Mask active = done < 1.0;
  while (true) {
    // A last step that is hardly shorter goes to the end.
    step = select(done + 1.125 * step > 1.0, 1.0 - done, step);
    active &= (done < 1.0) & (step >= kLeastStep);
    if (!any(active)) break;
    const V t = done + step;
    for (int r = 0; r < kRows; ++r) here[r] = select(t >= 1.0, to[r], from[r] + t * change[r]);
    // By the cubic through the last two points with their tangents, else by the tangent.
    C guess[kRows];
    const V q = select(before > 0.0, step / before, splat(0.0));
    for (int i = 0; i < kRows; ++i) {
      const C gap = now.at[i] - last.at[i];
      const C bend = before * (splat(2.0) * now.along[i] + last.along[i]) - splat(3.0) * gap;
      const C twist = before * (now.along[i] + last.along[i]) - splat(2.0) * gap;
      guess[i] = now.at[i] + step * now.along[i] + (q * q) * (bend + q * twist);
    }
    linearize(b, here, guess, at);
    newton_step(at, first);
    for (int i = 0; i < kRows; ++i) guess[i] = guess[i] - first[i];
    norm = linearize(b, here, guess, at);
    newton_step(at, second);
    for (int i = 0; i < kRows; ++i) guess[i] = guess[i] - second[i];
    const V one = largest(first), two = largest(second);
    // A comparison with NaN is false.
    Mask good = two <= kCertainly * one, easy = two <= kEasily * one;
    if (any(active & ~easy)) {
      const V least = noise(b, here, guess, at);
      const Mask exact = (one + two <= least) & (least <= kLostDigits * maximum(largest(guess), splat(kLeastSize)));
      good |= exact, easy |= exact;
    }
    good &= active;
    C along[kRows];
    differentiate_by_shift(b, at, norm, change, along);
    for (int i = 0; i < kRows; ++i) {
      last.at[i] = select(good, now.at[i], last.at[i]), last.along[i] = select(good, now.along[i], last.along[i]);
      now.at[i] = select(good, guess[i], now.at[i]), now.along[i] = select(good, along[i], now.along[i]);
    }
    before = select(good, step, before), done = select(good, t, done);
    step = select(good, select(easy, 2.0 * step, step), 0.5 * step);
  }
  const Mask arrived = done >= 1.0;
  for (int i = 0; i < kRows; ++i) s[i] = select(arrived, now.at[i], s[i]);
  return arrived;
}

constexpr double kShiftRounding = 0x1p-97;  // of `FineFarPoses.mix`
constexpr double kValueRounding = 0x1p-96;  // of `FineFarPoses.values`
// Second derivatives of products are bounded for coordinates that differ by no more.
constexpr double kReach = 0.125;
// Newton's method in doubles takes at most kMostSteps steps, each at most kShrinking times the one
// before. It has arrived after a step below kArrived times the coordinates (or times kNear, if they
// are smaller). At most kFineSteps steps with values of 32 digits follow.
constexpr int kMostSteps = 10, kFineSteps = 3;
constexpr double kShrinking = 0.5, kArrived = 1e-7, kNear = 1e-3;
// If Newton's method does not find the solution at the given values, the values are moved there in
// steps, each a multiple of this part of the way.
constexpr double kLeastPart = 0x1p-6;
constexpr int kEntries = 12, kNumbers = 16;
constexpr double kNothing = 5e-10;  // rounds to zero to nine digits

// Of the values in each lane: by how much they are greater, what double precision leaves of that, by how much it errs.
struct LaneValues {
  V shift[kEquations], low[kEquations], gap[kEquations];
  double unit[W];

  void put(int l, const FarValues& given, int row) {
    const double* const from = given.shift + 3 * kEquations * row;
    for (int r = 0; r < kEquations; ++r) {
      shift[r][l] = from[r], low[r][l] = from[kEquations + r], gap[r][l] = from[2 * kEquations + r];
    }
    unit[l] = given.unit[row];
  }
};

// The shift of each equation for values further by a shift: with 32 digits and in doubles, its modulus, and by how
// much it errs.
struct Shift {
  Shared<kRows> high, low;
  C at[kRows];
  V size[kRows], off[kRows];

  Shift(const Block& b, const LaneValues& values) {
    V own;
    __builtin_memcpy(&own, b.doubt, sizeof own);
    GSP_FINE_FAR.mix(b.numbers(), reinterpret_cast<const double*>(values.shift),
                     reinterpret_cast<const double*>(values.low), {high, low});
    high.load(at);
    for (int i = 0, k = kMixed; i < kRows; ++i) {
      V sum = splat(0.0);
      for (int r = 0; r < kEquations; ++r, ++k) {
        const V by = maximum(values.shift[r], -values.shift[r]), gap = values.gap[r];
        sum += bound(b.number(k)) * (gap + kShiftRounding * by) + own * (gap + by);
      }
      size[i] = bound(at[i]), off[i] = kOutward * sum;
    }
  }
};

// Bounds of rounding errors and doubts of a value, of the sum of its derivatives, and of that of its second ones.
struct Bounds {
  V value, slope, curvature;
};

// Of the quadric of an equation, F - c N.
INLINE Bounds bounds_of_quadric(const Sizes& form, const Sizes& norm, const V& by, const V& off, const V& own,
                                const V& total) {
  const V in_numbers = own * (1.0 + by);
  return {kValueRounding * (form.value + by * norm.value) + off * norm.value + in_numbers * total * total,
          kRounding * (form.slope + by * norm.slope) + off * norm.slope + 128.0 * in_numbers * total,
          form.curvature + by * norm.curvature + off * norm.curvature + 128.0 * in_numbers};
}

// Sizes of the factors of a product P Q - c N^2, and of what is doubtful in each of them, where coordinates are not
// larger than given.
struct Factors {
  Sizes p, q, norm, doubt;

  Factors(const Block& b, int r, const V* size, const V& own)
      : p(sizes_of(b, r * kLocalMonomials, size)),
        q(sizes_of(b, b.second[r], size)),
        norm(sizes_of(b, kOfNorm * kLocalMonomials, size)) {
    V total = splat(1.0);
    for (int i = 0; i < kRows; ++i) total += size[i];
    doubt = {own * total * total, 128.0 * own * total, 128.0 * own};
  }
};

// By how much a product of two numbers grows if they do by doubts.
INLINE V grown(const V& a, const V& a_doubt, const V& b, const V& b_doubt) {
  return a_doubt * b + (a + a_doubt) * b_doubt;
}

// Of a product. Its second derivatives are bounded within `kReach`.
Bounds bounds_of_product(const Block& b, int r, const V* size, const V& shift, const V& off, const V& own) {
  V wider[kRows];
  for (int i = 0; i < kRows; ++i) wider[i] = size[i] + kReach;
  const Factors at(b, r, size, own), near(b, r, wider, own);
  const V by = shift + bound(b.number(b.second[r] + kConstant)), by_off = off + own;
  const Sizes &p = at.p, &q = at.q, &n = at.norm, &d = at.doubt, &e = near.doubt;
  Bounds sum;
  const V norm = n.value + d.value, norm_slope = n.slope + d.slope;
  sum.value = 2.0 * kValueRounding * (p.value * q.value + by * n.value * n.value) +
              grown(p.value, d.value, q.value, d.value) + by * grown(n.value, d.value, n.value, d.value) +
              by_off * norm * norm;
  sum.slope = 4.0 * kRounding * (p.slope * q.value + p.value * q.slope + 2.0 * by * n.value * n.slope) +
              grown(p.slope, d.slope, q.value, d.value) + grown(q.slope, d.slope, p.value, d.value) +
              2.0 * (by * grown(n.slope, d.slope, n.value, d.value) + by_off * norm * norm_slope);
  const auto bent = [&](const Sizes& x, const Sizes& y) {
    return (x.curvature + e.curvature) * (y.value + e.value) + (x.slope + e.slope) * (y.slope + e.slope);
  };
  sum.curvature = bent(near.p, near.q) + bent(near.q, near.p) + 2.0 * (by + by_off) * bent(near.norm, near.norm);
  return sum;
}

// Whether there is exactly one solution near local coordinates, and a bound of its distance after Newton's step.
void isolate(const Block& b, const Shift& shift, const C* s, const Linear& at, Mask& isolated,
             V& error_after) {
  V size[kRows], rounding[kRows], curvature[kRows], doubt[kRows], total = splat(1.0), own;
  __builtin_memcpy(&own, b.doubt, sizeof own);
  for (int i = 0; i < kRows; ++i) size[i] = bound(s[i]), total += size[i];
  const Sizes norm = sizes_of(b, kOfNorm * kLocalMonomials, size);
  bool has_products = false;
  for (int r = 0; r < kRows; ++r) {
    // Each number has an error up to its doubt, and so has the shift.
    const bool is_product = b.second[r] != 0;
    const Bounds sum = is_product ? bounds_of_product(b, r, size, shift.size[r], shift.off[r], own)
                                  : bounds_of_quadric(sizes_of(b, r * kLocalMonomials, size), norm, shift.size[r],
                                                      shift.off[r], own, total);
    has_products |= is_product;
    rounding[r] = kOutward * sum.slope, curvature[r] = kOutward * sum.curvature;
    doubt[r] = kOutward * sum.value + kTiny;
    doubt[r] += kStepRounding * (bound(at.value[r]) + doubt[r]);
  }
  V a = splat(0.0), bend = splat(0.0), delta = splat(0.0), left = splat(0.0), sum = splat(0.0);
  for (int i = 0; i < kRows; ++i) {
    V defect = splat(0.0), bent = splat(0.0), doubtful = splat(0.0);
    C step{splat(0.0), splat(0.0)};
    for (int k = 0; k < kRows; ++k) {
      C x{splat(i == k ? 1.0 : 0.0), splat(0.0)};
      for (int j = 0; j < kRows; ++j) subtract_product(x, at.inverse[i][j], at.jacobian[j][k]);
      defect += bound(x);
    }
    for (int j = 0; j < kRows; ++j) {
      const V y = bound(at.inverse[i][j]);
      V row = rounding[j];
      for (int k = 0; k < kRows; ++k) row += kRounding * bound(at.jacobian[j][k]);
      defect += y * row, bent += y * curvature[j], doubtful += y * doubt[j];
      add_product(step, at.inverse[i][j], at.value[j]);
    }
    // Its terms cancel where the inverse is large.
    const V far = bound(step) + doubtful;
    a = maximum(defect, a), bend = maximum(bent, bend);
    delta = maximum(far, delta), left = maximum(doubtful, left);
    sum += defect + bent + far;
  }
  a = kOutward * a + kTiny, bend = kOutward * bend + kTiny, delta = kOutward * delta;
  V radius = (1.0 - a) / (2.0 * bend);
  if (has_products) radius = minimum(radius, splat(kReach));
  const V q = kOutward * (a + bend * radius);
  // NaN proves nothing: it is part of the sum.
  isolated = (sum < __builtin_inf()) & (q < 1.0) & (radius > 0.0) & (kOutward * delta <= (1.0 - q) * radius);
  const V error = kOutward * (delta / (1.0 - q));
  error_after = kOutward * ((a + bend * error) * error + left + 0x1p-100 * total);
}

struct Lanes {
  C entry[kNumbers];
  V deviation;
  Mask isolated, real, imaginary, rounded;
};

// Newton's method in doubles; returns in which lanes it has found a solution.
Mask converge(const Block& b, const C* shift, C* s) {
  C change[kRows];
  Linear at;
  V last = splat(__builtin_inf());
  Mask arrived{}, lost{};
  for (int step = 0; step < kMostSteps; ++step) {
    linearize(b, shift, s, at);
    newton_step(at, change);
    V length = splat(0.0), size = splat(kNear);
    for (int i = 0; i < kRows; ++i) {
      s[i] = s[i] - change[i];
      length = maximum(length, bound(change[i])), size = maximum(size, bound(s[i]));
    }
    arrived = length <= kArrived * size;
    // A comparison with NaN is false.
    lost |= ~(arrived | (length <= kShrinking * last));
    last = length;
    if (!any(~arrived & ~lost)) break;
  }
  return arrived & ~lost;
}

// Local coordinates of solutions of shifted equations, as well as they are found from the poses that
// are known.
void follow(const Block& b, const C* shift, C* s) {
  const Mask found = converge(b, shift, s);
  C reached[kRows];
  for (int i = 0; i < kRows; ++i) reached[i] = {splat(0.0), splat(0.0)};
  V done = splat(0.0), part = splat(0.5);
  for (Mask left = ~found; any(left); left = ~found & (done < 1.0) & (part >= kLeastPart)) {
    C here[kRows], moved[kRows];
    for (int r = 0; r < kRows; ++r) here[r] = (done + part) * shift[r];
    for (int i = 0; i < kRows; ++i) moved[i] = reached[i];
    const Mask good = converge(b, here, moved) & left;
    for (int i = 0; i < kRows; ++i) reached[i] = select(good, moved[i], reached[i]);
    done = select(good, done + part, done), part = select(good, part, 0.5 * part);
  }
  for (int i = 0; i < kRows; ++i) s[i] = select(found, s[i], reached[i]);
}

// Coordinates beside which an imaginary part is rounding.
constexpr double kImaginary = 1e-8;

// Makes coordinates real that are so but for rounding, where equations are: from them a solution is proved to be real.
void round_to_real(const Block& b, C* s) {
  const V size = largest(s);
  V height = splat(0.0);
  for (int i = 0; i < kRows; ++i) height = maximum(height, maximum(s[i].im, -s[i].im));
  for (int l = 0; l < W; ++l)
    if (b.real[l] != 0.0 && height[l] <= kImaginary * size[l])
      for (int i = 0; i < kRows; ++i) s[i].im[l] = 0.0;
}

// Local coordinates of the poses to which paths lead, of shifted equations.
void follow_paths(const FarGeometry& g, const Block& b, const C* shift, C* s) {
  C from[kRows], end[kRows];
  mix(b, g.origin, from);
  const Mask found = follow_line(b, from, shift, s);
  for (int i = 0; i < kRows; ++i) end[i] = s[i];
  converge(b, shift, end);
  for (int i = 0; i < kRows; ++i) s[i] = select(found, end[i], s[i]);
}

// Newton's method in doubles, then with values of 32 digits until those are rounded.
void prove(const FarGeometry& g, const Block& b, Shift& shift, C* s, const double* unit, Lanes& out) {
  C low[kRows] = {}, change[kRows];
  Linear at;
  // Only real numbers and real coordinates occur.
  double is_real[W];
  for (int l = 0; l < W; ++l) {
    is_real[l] = b.real[l];
    for (int i = 0; i < kRows; ++i)
      if (s[i].im[l] != 0.0) is_real[l] = 0.0;
  }
  Shared<kRows> local, rest, value, moved;
  Shared<kNumbers> entry;
  double errors[W], deviation[W], rounded[W];
  for (int step = 0;; ++step) {
    local.store(s), rest.store(low);
    linearize(b, shift.at, s, at);
    GSP_FINE_FAR.values(b.numbers(), b.second, {local, rest}, {shift.high, shift.low}, value);
    value.load(at.value);
    newton_step(at, change);
    // The factors of products are not real: rounding of their product is no part of it.
    for (int l = 0; l < W; ++l)
      for (int i = 0; i < kRows && is_real[l] != 0.0; ++i) change[i].im[l] = 0.0;
    moved.store(change);
    V error;
    isolate(b, shift, s, at, out.isolated, error);
    __builtin_memcpy(errors, &error, sizeof error);
    GSP_FINE_FAR.poses(b.numbers(), {local, rest}, moved, errors, b.doubt, is_real, unit,
                       {entry, deviation, rounded});
    bool all = true;
    for (int l = 0; l < W; ++l) all = all && rounded[l] != 0.0 && out.isolated[l];
    if (all || step == kFineSteps) break;
    for (int i = 0; i < kRows; ++i)
      subtract(s[i].re, low[i].re, change[i].re), subtract(s[i].im, low[i].im, change[i].im);
  }
  entry.load(out.entry);
  V largest = splat(1.0), height = splat(0.0);
  for (int l = 0; l < W; ++l) {
    out.deviation[l] = deviation[l];
    out.rounded[l] = rounded[l] != 0.0 ? -1 : 0, out.real[l] = is_real[l] != 0.0 ? -1 : 0;
  }
  for (int i = 0; i < kEntries; ++i) {
    largest = maximum(largest, root(square(out.entry[i])));
    height = maximum(height, maximum(out.entry[i].im, -out.entry[i].im));
  }
  out.isolated = out.isolated & (out.deviation <= g.tolerance * largest);
  // Real equations have conjugate solutions: the only one near real coordinates is real.
  out.real = out.real & out.isolated;
  out.imaginary = out.isolated & (height > out.deviation);
  out.rounded = out.rounded & out.isolated;
}

INLINE Complex conjugate(const Complex& z) { return {z.re, -z.im + 0.0}; }

// A pose, and its conjugate if it is not real, at places of one set of values.
void put_pose(const Lanes& s, int l, double scale, int place, int other, const Poses& out) {
  for (int i = 0; i < 9; ++i) out.rotation[9 * place + i] = lane(s.entry[i], l);
  for (int i = 0; i < 3; ++i) out.translation[3 * place + i] = lane(splat(scale) * s.entry[9 + i], l);
  for (int i = 0; i < 4; ++i) out.quaternion[4 * place + i] = lane(s.entry[kEntries + i], l);
  out.deviation[place] = lane(s.deviation, l);
  out.proved[place] =
      static_cast<std::uint8_t>((s.isolated[l] ? kIsolated : 0) | (s.real[l] ? kReal : 0) |
                                (s.imaginary[l] ? kComplex : 0) | (s.rounded[l] ? kRounded : 0));
  if (other < 0) return;
  for (int i = 0; i < 9; ++i) out.rotation[9 * other + i] = conjugate(out.rotation[9 * place + i]);
  for (int i = 0; i < 3; ++i) out.translation[3 * other + i] = conjugate(out.translation[3 * place + i]);
  // The first part that is not zero to nine digits is positive (`quaternions.canonical_sign`).
  const Complex* e = out.quaternion + 4 * place;
  double sign = 1.0;
  for (int i = 4; i-- > 0;) {
    if (e[i].im > kNothing || e[i].im < -kNothing) sign = e[i].im > 0.0 ? -1.0 : 1.0;
    if (e[i].re > kNothing || e[i].re < -kNothing) sign = e[i].re > 0.0 ? 1.0 : -1.0;
  }
  for (int i = 0; i < 4; ++i)
    out.quaternion[4 * other + i] = {sign * e[i].re + 0.0, -sign * e[i].im + 0.0};
  out.deviation[other] = out.deviation[place], out.proved[other] = out.proved[place];
}

bool apart(const Complex& a, const Complex& b, double reach) {
  const double re = a.re - b.re, im = a.im - b.im;
  return re > reach || -re > reach || im > reach || -im > reach;
}

// Whether poses are all proved, and different from each other.
bool is_complete(int first, int count, double scale, const Poses& out) {
  for (int p = first; p < first + count; ++p) {
    if (!(out.proved[p] & (kReal | kComplex))) return false;
    for (int q = first; q < p; ++q) {
      const double reach = kOutward * (out.deviation[p] + out.deviation[q]);
      bool different = false;
      for (int i = 0; i < 9 && !different; ++i)
        different = apart(out.rotation[9 * p + i], out.rotation[9 * q + i], reach);
      for (int i = 0; i < 3 && !different; ++i)
        different = apart(out.translation[3 * p + i], out.translation[3 * q + i], scale * reach);
      if (!different) return false;
    }
  }
  return true;
}

// Poses of one sort, each for all sets of values before the next: as many at a time as there are lanes.
void decide_sort(const FarGeometry& g, const FarValues& given, int begin, int end, bool is_bent, int total,
                 double* work, const Poses& out) {
  const int all = (end - begin) * given.count;
  int before[W] = {};
  Block b;
  for (int first = 0; first < all; first += W) {
    const int size = all - first < W ? all - first : W;
    int pose[W];
    LaneValues values;
    C local[kRows];
    for (int i = 0; i < kRows; ++i) local[i] = {splat(0.0), splat(0.0)};
    bool is_new = first == 0;
    for (int l = 0; l < W; ++l) {
      // Lanes beyond the last one repeat the first.
      const int at = first + (l < size ? l : 0);
      pose[l] = begin + at / given.count;
      values.put(l, given, at % given.count);
      is_new = is_new || pose[l] != before[l];
      before[l] = pose[l];
      for (int i = 0; i < kRows && is_bent; ++i) put(local[i], l, g.start[(pose[l] - begin) * kRows + i]);
    }
    if (is_new) b = packed(g, pose, work);
    Lanes s;
    Shift shift(b, values);
    if (is_bent)
      follow_paths(g, b, shift.at, local);
    else
      follow(b, shift.at, local);
    round_to_real(b, local);
    prove(g, b, shift, local, values.unit, s);
    for (int l = 0; l < size; ++l) {
      const int place = (first + l) % given.count * total;
      int other = -1;
      if (g.paired[pose[l]]) {
        other = place + g.count;
        for (int p = 0; p < pose[l]; ++p) other += g.paired[p];
      }
      put_pose(s, l, g.scale, place + pose[l], other, out);
    }
  }
}

void decide(const FarGeometry& g, const FarValues& given, double* work, const Poses& out) {
  int total = g.count;
  for (int p = 0; p < g.count; ++p) total += g.paired[p];
  const int straight = g.count - g.bent;
  decide_sort(g, given, 0, straight, false, total, work, out);
  decide_sort(g, given, straight, g.count, true, total, work, out);
  for (int row = 0; row < given.count; ++row) out.complete[row] = is_complete(row * total, total, g.scale, out);
}

}  // namespace

void GSP_DECIDE_FAR(const FarGeometry& geometry, const FarValues& given, double* work, const Poses& poses) {
  decide(geometry, given, work, poses);
}

void GSP_FOLLOW_FAR(const FarGeometry& g, const Complex* from, const Complex* to, double* work, Complex* local,
                    std::uint8_t* found) {
  // One by one, so that a lost pose does not affect the others.
  for (int p = 0; p < g.count; ++p) {
    FarGeometry one = g;
    const int at = p * far_numbers(g.products);
    one.count = 1, one.number += at, one.low += at, one.error += p, one.real += p;
    const int none[W] = {};
    const Block b = packed(one, none, work);
    C s[kRows];
    for (int i = 0; i < kRows; ++i) {
      const Complex& x = local[p * kRows + i];
      s[i] = {splat(x.re), splat(x.im)};
    }
    C begin[kRows], end[kRows];
    mix(b, from, begin), mix(b, to, end);
    found[p] = follow_line(b, begin, end, s)[0] != 0;
    for (int i = 0; i < kRows; ++i) local[p * kRows + i] = lane(s[i], 0);
  }
}

}  // namespace gsp
