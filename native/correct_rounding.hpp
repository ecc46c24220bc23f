// Numbers of 32 digits of as many poses as a build has lanes, and their correct rounding
// (gspcli.certification.numbers.correct_rounding).
//
// Included by fine_points.cpp and fine_far_poses.cpp, built with GSP_PARTS = 2: all in an anonymous
// namespace, so that the linker cannot merge functions that were compiled for different processors.
#pragma once

#include "fine_points.hpp"

#include "lanes.hpp"

namespace gsp {
namespace {

constexpr int kEntries = 16, kOfR = 9, kOfPose = 12;
constexpr double kOutward = 1.0 + 0x1p-40;
// Bound of the relative rounding errors of everything computed here.
constexpr double kRounding = 0x1p-90;
// Numbers below the first are rounded to multiples of the second (`round_entry`).
constexpr double kSmall = 0x1p-12, kGrid = 0x1p-64;
// Complex numbers that err by no more than this part of the largest are doubles within 2^-53 of it.
constexpr double kAccurate = 0x1p-55;
constexpr double kNothing = 5e-10;  // rounds to zero to nine digits

#if !defined(GSP_FUSED)
INLINE D fused(const D& a, const D& b, const D& c) { return a * b + c; }
#endif

// Sums and products as those of lanes.hpp, less one step: the low part may be a few units of the
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

// An upper bound of the modulus of z, not much above it. After cancellation the low part may be as large as the high one.
INLINE D bound(const C& z) {
  const D re = z.re.hi + z.re.lo, im = z.im.hi + z.im.lo;
  return kOutward * ((re < 0.0 ? -re : re) + (im < 0.0 ? -im : im));
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
  return {((s.hi + rest) - base) + 0.0, up == down};
}

// The power of two above the largest part of some numbers, rounded, but not less than another one.
INLINE D unit_of(const C* numbers, int count, const D& least) {
  D largest = 0.5 * least;
  for (int i = 0; i < count; ++i)
    for (int k = 0; k < 2; ++k) {
      const V& x = k ? numbers[i].im : numbers[i].re;
      const D part = x.hi + x.lo, size = part < 0.0 ? -part : part;
      largest = size > largest ? size : largest;
    }
  constexpr long long kExponent = 0x7ff0000000000000, kOne = 0x0010000000000000;
  return (D)(((Mask)largest & kExponent) + kOne);
}

// The numbers of poses that are known up to errors (16), in doubles: real ones rounded correctly, complex ones accurate.
void put_rounded(const C* entry, const D* error, const Mask& real, const D& unit, const FinePoses& out) {
  D re[kEntries], im[kEntries], deviation = D{};
  const D turning = unit_of(entry, kOfR, D{}), moving = unit_of(entry + kOfR, kOfPose - kOfR, unit),
          quaternion = unit_of(entry + kOfPose, kEntries - kOfPose, D{});
  Mask sure = real | ~real;
  for (int i = 0; i < kEntries; ++i) {
    const D here = i < kOfR ? turning : i < kOfPose ? moving : quaternion;
    const Rounded a = round_entry(entry[i].re, error[i], here), b = round_entry(entry[i].im, error[i], here);
    re[i] = a.value, im[i] = real ? D{} : b.value;
    const Mask accurate = error[i] <= kAccurate * here;
    sure &= (real & a.sure) | (~real & accurate);
    if (i >= kOfPose) continue;
    // A number that is not proved to be rounded correctly can differ by its error in either part.
    const D off = 3.0 * error[i] + 0x1p-52 * bound(entry[i]) + kGrid * here;
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

}  // namespace
}  // namespace gsp
