// Built with GSP_PARTS = 2: lanes of double-double numbers.
#include "fine_points.hpp"

#include "lanes.hpp"
#include "pair.hpp"

namespace gsp {
namespace {

constexpr int kEntries = 16, kOfR = 9, kOfPose = 12;
constexpr double kOutward = 1.0 + 0x1p-40;
// Bound of the relative rounding errors of everything computed here.
constexpr double kRounding = 0x1p-90;
// Numbers below the first are rounded to multiples of the second (`round_entry`).
constexpr double kSmall = 0x1p-12, kGrid = 0x1p-64;
constexpr double kNothing = 5e-10;  // rounds to zero to nine digits

int monomial(int i, int j) { return i < 4 && j < 4 ? 4 * i - i * (i - 1) / 2 + j - i : 10 + 4 * i + j - 4; }

// A coefficient of the quadric z^T H z / 2, the Hessian matrix H given in two parts.
void put_coefficients(const Pair* hessian, double* high, double* low) {
  for (int i = 0; i < N; ++i)
    for (int j = i; j < N; ++j) {
      // Of f and f nothing but f . f is there.
      if (i > 4 || (i == 4 && j > 4)) continue;
      const int at = i == 4 ? kMonomials - 1 : monomial(i, j);
      const double factor = i == j ? 0.5 : 1.0;
      high[at] = factor * hessian[N * i + j].hi, low[at] = factor * hessian[N * i + j].lo;
    }
}

void coefficients(const FineGeometry& g, const FineValues& given, double* high, double* low) {
  Pair hessian[N * N];
  int equation[kMostQuadrics], turning[kMostQuadrics];
  for (int q = 0; q < g.quadrics; ++q) equation[q] = turning[q] = -1;
  for (int r = 0; r < kEquations; ++r) {
    equation[g.equation[r].main] = r;
    if (g.turned[r] >= 0) turning[g.turned[r]] = r;
  }
  for (int q = 0; q < g.quadrics; ++q) {
    for (int i = 0; i < N * N; ++i)
      hessian[i] = {g.hessian[q * N * N + i], g.hessian_low[q * N * N + i]};
    if (const int r = equation[q]; r >= 0) {
      const Pair shift = product({g.weight[r], g.weight_low[r]}, {given.value[r], given.value_low[r]});
      for (int i = 0; i < 4; ++i)
        hessian[i * (N + 1)] = sum(hessian[i * (N + 1)], {2.0 * shift.hi, 2.0 * shift.lo});
    }
    if (const int r = turning[q]; r >= 0)
      for (Pair& x : hessian) x = product(x, {given.distance[r], given.distance_low[r]});
    put_coefficients(hessian, high + q * kMonomials, low + q * kMonomials);
  }
}

#if !defined(GSP_FUSED)
INLINE D fused(const D& a, const D& b, const D& c) { return a * b + c; }
#endif

// Sums and products as those of double_double.hpp, less one step: the low part may be a few units of the
// last digit of the high one. They err by less than 2^-100 of the moduli of what is added.
INLINE V plus(const V& a, const V& b) {
  const V s = exact_sum(a.hi, b.hi);
  return {s.hi, s.lo + (a.lo + b.lo)};
}
INLINE V minus(const V& a, const V& b) { return plus(a, -b); }
INLINE V times(const V& a, const V& b) {
  const V p = exact_product(a.hi, b.hi);
  return {p.hi, fused(a.hi, b.lo, fused(a.lo, b.hi, p.lo))};
}
INLINE C plus(const C& a, const C& b) { return {plus(a.re, b.re), plus(a.im, b.im)}; }
INLINE C minus(const C& a, const C& b) { return {minus(a.re, b.re), minus(a.im, b.im)}; }
INLINE C times(const C& a, const C& b) {
  return {minus(times(a.re, b.re), times(a.im, b.im)), plus(times(a.re, b.im), times(a.im, b.re))};
}
INLINE C twice(const C& a) { return {{a.re.hi + a.re.hi, a.re.lo + a.re.lo}, {a.im.hi + a.im.hi, a.im.lo + a.im.lo}}; }

// A sum of products with twice the digits (T. Ogita, S. M. Rump, S. Oishi, Accurate sum and dot product,
// 2005).
struct Total {
  D high = D{}, rest = D{};
  INLINE void add(const D& a, const D& a_low, const V& x) {
    const V p = exact_product(a, x.hi), s = exact_sum(high, p.hi);
    high = s.hi;
    rest += s.lo + fused(a, x.lo, fused(a_low, x.hi, p.lo));
  }
  INLINE V total() const { return {high, rest}; }
};

INLINE D load(const double* from, int k) {
  D x;
  __builtin_memcpy(&x, from + k * W, sizeof x);
  return x;
}
INLINE void store(double* to, int k, const D& x) { __builtin_memcpy(to + k * W, &x, sizeof x); }
INLINE C load(const FineNumbers& from, int k) {
  return {{load(from.high.re, k), load(from.low.re, k)}, {load(from.high.im, k), load(from.low.im, k)}};
}
INLINE void store(const FineNumbers& to, int k, const C& x) {
  store(to.high.re, k, x.re.hi), store(to.low.re, k, x.re.lo);
  store(to.high.im, k, x.im.hi), store(to.low.im, k, x.im.lo);
}

void values(int quadrics, const ProofEquation* equations, const double* high, const double* low,
            const FineNumbers& point, const FineNumbers& monomials, const LaneNumbers& out) {
  C z[N], m[kMonomials], quadric[kMostQuadrics];
  for (int i = 0; i < N; ++i) z[i] = load(point, i);
  for (int i = 0; i < 4; ++i)
    for (int j = i; j < N; ++j) m[monomial(i, j)] = times(z[i], z[j]);
  m[kMonomials - 1] =
      plus(plus(times(z[4], z[4]), times(z[5], z[5])), plus(times(z[6], z[6]), times(z[7], z[7])));
  for (int k = 0; k < kMonomials; ++k) store(monomials, k, m[k]);
  for (int q = 0; q < quadrics; ++q) {
    Total re, im;
    for (int k = 0; k < kMonomials; ++k) {
      const double a = high[q * kMonomials + k], a_low = low[q * kMonomials + k];
      if (a == 0.0 && a_low == 0.0) continue;
      re.add(D{} + a, D{} + a_low, m[k].re);
      im.add(D{} + a, D{} + a_low, m[k].im);
    }
    quadric[q] = {re.total(), im.total()};
  }
  const auto put_value = [&](int r, const C& value) {
    store(out.re, r, value.re.hi + value.re.lo), store(out.im, r, value.im.hi + value.im.lo);
  };
  put_value(0, quadric[1]);
  for (int r = 0; r < kEquations; ++r) {
    const ProofEquation& e = equations[r];
    C s = quadric[e.main];
    if (e.squares[0] >= 0) s = times(quadric[0], s);
    for (const int b : e.squares)
      if (b >= 0) s = minus(s, times(quadric[b], quadric[b]));
    put_value(r + 1, s);
  }
}

// The monomials of e, and of e and f, less what a change of the point makes of them.
INLINE C moved(const FineNumbers& monomials, const FineNumbers& point, const LaneNumbers& change, int i,
               int j) {
  C m = load(monomials, monomial(i, j));
  const D a = load(point.high.re, i), b = load(point.high.im, i), c = load(point.high.re, j),
          d = load(point.high.im, j);
  const D p = load(change.re, i), q = load(change.im, i), r = load(change.re, j), s = load(change.im, j);
  // z_i c_j + (z_j - c_j) c_i
  const D u = c - r, v = d - s;
  m.re.lo -= (a * r - b * s) + (u * p - v * q);
  m.im.lo -= (a * s + b * r) + (u * q + v * p);
  return m;
}

// N, and N R by rows, N T (`study.motion`).
void motion(const FineNumbers& monomials, const FineNumbers& point, const LaneNumbers& change, C& norm,
            C* entry) {
  const auto e = [&](int i, int j) { return moved(monomials, point, change, i < j ? i : j, i < j ? j : i); };
  const auto of_f = [&](int i, int j) { return moved(monomials, point, change, i, 4 + j); };
  C square[4];
  for (int i = 0; i < 4; ++i) square[i] = e(i, i);
  norm = plus(plus(square[0], square[1]), plus(square[2], square[3]));
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    entry[4 * i] = minus(plus(square[0], square[i + 1]), plus(square[j + 1], square[k + 1]));
    const C skew = e(0, k + 1), even = e(i + 1, j + 1);
    entry[3 * i + j] = twice(minus(even, skew));
    entry[3 * j + i] = twice(plus(even, skew));
    // Of f times the conjugate of e.
    entry[kOfR + i] = twice(plus(minus(of_f(0, i + 1), of_f(i + 1, 0)),
                                 minus(of_f(j + 1, k + 1), of_f(k + 1, j + 1))));
  }
}

// Not below the modulus of z, and not much above it.
INLINE D bound(const C& z) {
  const D re = z.re.hi < 0.0 ? -z.re.hi : z.re.hi, im = z.im.hi < 0.0 ? -z.im.hi : z.im.hi;
  return kOutward * (re + im);
}

// 1 / z.
INLINE C inverse(const C& z) {
  const V size = plus(times(z.re, z.re), times(z.im, z.im));
  const D first = 1.0 / size.hi;
  const V p = exact_product(first, size.hi);
  const V part{first, first * (((1.0 - p.hi) - p.lo) - first * size.lo)};
  return {times(part, z.re), times(part, -z.im)};
}

// A square root of a complex number that is not zero: in double precision, then Newton's method.
C complex_root(const C& z) {
  const D re = z.re.hi, im = z.im.hi, size = root(re * re + im * im);
  const D other = root(0.5 * (size + (re < 0.0 ? -re : re)));
  const D half = 0.5 * (im < 0.0 ? -im : im) / other;
  const Mask right = re > 0.0;
  const D x = right ? other : half, y = im < 0.0 ? -(right ? half : other) : (right ? half : other);
  const C first{V(x), V(y)};
  const C left = minus(z, times(first, first));
  const D scale = 0.5 / (x * x + y * y), a = left.re.hi + left.re.lo, b = left.im.hi + left.im.lo;
  return {{x, scale * (x * a + y * b)}, {y, scale * (x * b - y * a)}};
}

struct Rounded {
  D value;
  Mask sure;
};

// The double nearest to a number that is known up to an error; of numbers below kSmall units the
// nearest multiple of kGrid units.
INLINE Rounded round_entry(const V& number, const D& error, const D& unit) {
  // A sum that cancels may leave a low part above the high one, of the other sign.
  const V x = exact_sum(number.hi, number.lo);
  const D size = x.hi < 0.0 ? -x.hi : x.hi, none = D{};
  // The sum is of the binade whose last digit is kGrid units.
  const D small = kSmall * unit, base = size < small ? (x.hi < 0.0 ? 2.0 * small : small) : none;
  const V s = exact_sum(base, x.hi);
  const D rest = s.lo + x.lo, reach = kOutward * (error + 0x1p-50 * (rest < 0.0 ? -rest : rest));
  const D up = s.hi + (rest + reach), down = s.hi + (rest - reach);
  // Zero has one sign.
  return {(up - base) + 0.0, up == down};
}

// The power of two above the largest part of some numbers, rounded, but not less than another one.
INLINE D unit_of(const C* numbers, int count, double least) {
  D largest = D{} + 0.5 * least;
  for (int i = 0; i < count; ++i)
    for (int k = 0; k < 2; ++k) {
      const V& x = k ? numbers[i].im : numbers[i].re;
      const D part = x.hi + x.lo, size = part < 0.0 ? -part : part;
      largest = size > largest ? size : largest;
    }
  constexpr long long kExponent = 0x7ff0000000000000, kOne = 0x0010000000000000;
  return (D)(((Mask)largest & kExponent) + kOne);
}

// How far the pose of a point may be from that of another within an error, and the quaternion.
struct Reach {
  D turning, moving, least;
};

INLINE Reach reach_of(const C* z, const D& error, const C& norm) {
  D turning = D{}, moving = D{};
  for (int i = 0; i < N; ++i) {
    moving += bound(z[i]);
    if (i < 4) turning += bound(z[i]);
  }
  turning = 2.0 * turning * error + 8.0 * error * error + kRounding * turning * turning;
  moving = 2.0 * moving * error + 8.0 * error * error + kRounding * moving * moving;
  const D size = root(norm.re.hi * norm.re.hi + norm.im.hi * norm.im.hi);
  return {turning, moving, (1.0 - 0x1p-40) * size - kOutward * turning};
}

// The numbers of poses that are known up to errors (16), rounded.
void put_rounded(const C* entry, const D* error, const Mask& real, double unit, const FinePoses& out) {
  D re[kEntries], im[kEntries], deviation = D{};
  const D turning = unit_of(entry, kOfR, 0.0), moving = unit_of(entry + kOfR, kOfPose - kOfR, unit),
          quaternion = unit_of(entry + kOfPose, kEntries - kOfPose, 0.0);
  Mask sure = real | ~real;
  for (int i = 0; i < kEntries; ++i) {
    const D here = i < kOfR ? turning : i < kOfPose ? moving : quaternion;
    const Rounded a = round_entry(entry[i].re, error[i], here), b = round_entry(entry[i].im, error[i], here);
    re[i] = a.value, im[i] = real ? D{} : b.value;
    sure &= a.sure & (b.sure | real);
    if (i >= kOfPose) continue;
    const D off = error[i] + 0x1p-52 * bound(entry[i]) + kGrid * here;
    deviation = off > deviation ? off : deviation;
  }
  // The first part that is not zero to nine digits is positive (`quaternions.canonical_sign`).
  D sign = D{} + 1.0;
  for (int i = kEntries; i-- > kOfPose;) {
    const D parts[] = {im[i], re[i]};
    for (const D& part : parts) {
      sign = part > kNothing ? D{} + 1.0 : sign;
      sign = part < -kNothing ? D{} - 1.0 : sign;
    }
  }
  for (int i = 0; i < kEntries; ++i) {
    store(out.entry.re, i, (i < kOfPose ? re[i] : sign * re[i]) + 0.0);
    store(out.entry.im, i, (i < kOfPose ? im[i] : sign * im[i]) + 0.0);
  }
  store(out.deviation, 0, kOutward * deviation);
  store(out.rounded, 0, sure ? D{} + 1.0 : D{});
}

void poses(const FineNumbers& point, const FineNumbers& monomials, const LaneNumbers& change,
           const double* error, const double* real, double unit, const FinePoses& out) {
  C z[N], norm, entry[kEntries];
  const D off = load(error, 0);
  const Mask is_real = load(real, 0) != 0.0;
  for (int i = 0; i < N; ++i) {
    const C x = load(point, i);
    z[i] = {exact_sum(x.re.hi, x.re.lo - load(change.re, i)), exact_sum(x.im.hi, x.im.lo - load(change.im, i))};
  }
  motion(monomials, point, change, norm, entry);
  // The real part is no further from a real solution.
  const V none{D{}, D{}};
  for (int i = 0; i < 4; ++i) z[i].im = select(is_real, none, z[i].im);
  norm.im = select(is_real, none, norm.im);
  for (int i = 0; i < kOfPose; ++i) entry[i].im = select(is_real, none, entry[i].im);
  const Reach reach = reach_of(z, off, norm);
  const C factor = inverse(norm), part = inverse(complex_root(norm));
  const D size = root(norm.re.hi * norm.re.hi + norm.im.hi * norm.im.hi), length = root(size);
  const D least = reach.least > 0.0 ? kOutward / reach.least : D{} + __builtin_inf();
  D errors[kEntries];
  for (int i = 0; i < kEntries; ++i) {
    D change_of;
    if (i < kOfPose) {
      entry[i] = times(factor, entry[i]);
      change_of = (i < kOfR ? reach.turning : reach.moving) + bound(entry[i]) * (reach.turning + kRounding * size);
    } else {
      // |sqrt(N') - sqrt(N)| <= |N' - N| / |sqrt(N)|.
      entry[i] = times(part, z[i - kOfPose]);
      change_of = length * off + bound(entry[i]) * (reach.turning + kRounding * size);
    }
    errors[i] = change_of * least;
  }
  put_rounded(entry, errors, is_real, unit, out);
}

}  // namespace

extern const FinePoints GSP_FINE;
const FinePoints GSP_FINE{coefficients, values, poses};

}  // namespace gsp
