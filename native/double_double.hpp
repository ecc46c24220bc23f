// Vectors of double-double numbers: an unevaluated sum hi + lo of two doubles has 32 digits.
//
// Sums and products by the error-free transformations of T. J. Dekker (A floating-point technique
// for extending the available precision, 1971) and D. E. Knuth, as in Y. Hida, X. S. Li, D. H.
// Bailey (Library for double-double and quad-double arithmetic, 2007). Nothing here may be
// reassociated, and a product may be contracted only where it is written as a fused one.
//
// Included by lanes.hpp: in an anonymous namespace, as everything there.
#pragma once

#include "mixed_operators.hpp"

namespace gsp {
namespace {

struct DoubleDouble {
  static constexpr int kParts = 2;
  D hi, lo;
  DoubleDouble() = default;
  explicit INLINE DoubleDouble(const D& x) : hi(x), lo{} {}
  INLINE DoubleDouble(const D& a, const D& b) : hi(a), lo(b) {}
  // Vector by vector, as C in lanes.hpp.
  INLINE DoubleDouble(const DoubleDouble& o) : hi(o.hi), lo(o.lo) {}
  INLINE DoubleDouble& operator=(const DoubleDouble& o) {
    hi = o.hi, lo = o.lo;
    return *this;
  }
};

// hi + lo, if |a| >= |b|.
INLINE DoubleDouble quick_sum(const D& a, const D& b) {
  const D s = a + b;
  return {s, b - (s - a)};
}

// a + b without error.
INLINE DoubleDouble exact_sum(const D& a, const D& b) {
  const D s = a + b, v = s - a;
  return {s, (a - (s - v)) + (b - v)};
}

// a b without error.
INLINE DoubleDouble exact_product(const D& a, const D& b) {
  const D p = a * b;
#if defined(GSP_FUSED)
  return {p, fused(a, b, -p)};
#else
  // Without such an instruction by halves (Veltkamp, Dekker), for numbers below 2^996.
  const D x = 134217729.0 * a, y = 134217729.0 * b;
  const D high = x - (x - a), other = y - (y - b), low = a - high, rest = b - other;
  return {p, ((high * other - p) + high * rest + low * other) + low * rest};
#endif
}

INLINE DoubleDouble operator-(const DoubleDouble& a) { return {-a.hi, -a.lo}; }
INLINE DoubleDouble operator+(const DoubleDouble& a, const DoubleDouble& b) {
  const DoubleDouble s = exact_sum(a.hi, b.hi), t = exact_sum(a.lo, b.lo);
  const DoubleDouble u = quick_sum(s.hi, s.lo + t.hi);
  return quick_sum(u.hi, u.lo + t.lo);
}
INLINE DoubleDouble operator*(const DoubleDouble& a, const DoubleDouble& b) {
  const DoubleDouble p = exact_product(a.hi, b.hi);
  return quick_sum(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
}
INLINE DoubleDouble operator*(const D& a, const DoubleDouble& b) {
  const DoubleDouble p = exact_product(a, b.hi);
  return quick_sum(p.hi, p.lo + a * b.lo);
}
INLINE DoubleDouble operator/(const DoubleDouble& a, const DoubleDouble& b) {
  const D first = a.hi / b.hi;
  const DoubleDouble left = a - first * b;
  return quick_sum(first, left.hi / b.hi);
}

INLINE Mask operator<(const DoubleDouble& a, const DoubleDouble& b) {
  return (a.hi < b.hi) | ((a.hi == b.hi) & (a.lo < b.lo));
}
INLINE Mask operator<=(const DoubleDouble& a, const DoubleDouble& b) {
  return (a.hi < b.hi) | ((a.hi == b.hi) & (a.lo <= b.lo));
}

INLINE DoubleDouble select(const Mask& m, const DoubleDouble& a, const DoubleDouble& b) {
  return {m ? a.hi : b.hi, m ? a.lo : b.lo};
}

// The square root of numbers that are not negative.
INLINE DoubleDouble root(const DoubleDouble& x) {
  const D first = root(x.hi);
  const DoubleDouble left = x - exact_product(first, first);
  const D correction = first > 0.0 ? left.hi / (first + first) : first;
  return quick_sum(first, correction);
}

// Sets one of the two doubles in all lanes.
INLINE void put_part(DoubleDouble& x, int part, double value) { (part ? x.lo : x.hi) = D{} + value; }
INLINE double lane(const DoubleDouble& x, int l) { return x.hi[l]; }
INLINE double part_of(const DoubleDouble& x, int l, int part) { return (part ? x.lo : x.hi)[l]; }
INLINE void set_part(DoubleDouble& x, int l, int part, double value) {
  (part ? x.lo : x.hi)[l] = value;
}
INLINE void put(DoubleDouble& x, int l, double value) {
  x.hi[l] = value;
  x.lo[l] = 0.0;
}

}  // namespace
}  // namespace gsp
