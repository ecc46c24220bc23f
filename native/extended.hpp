// Vectors of double-double numbers: an unevaluated sum hi + lo of two doubles has 32 digits.
//
// Sums and products by the error-free transformations of T. J. Dekker (A floating-point technique
// for extending the available precision, 1971) and D. E. Knuth, as in Y. Hida, X. S. Li, D. H.
// Bailey (Library for double-double and quad-double arithmetic, 2007). Nothing here may be
// reassociated, and a product may be contracted only where it is written as a fused one.
//
// Included by lanes.hpp: in an anonymous namespace, as everything there.
#pragma once

namespace gsp {
namespace {

struct Extended {
  D hi, lo;
  Extended() = default;
  INLINE Extended(const D& a, const D& b) : hi(a), lo(b) {}
  // Vector by vector, as C in lanes.hpp.
  INLINE Extended(const Extended& o) : hi(o.hi), lo(o.lo) {}
  INLINE Extended& operator=(const Extended& o) {
    hi = o.hi, lo = o.lo;
    return *this;
  }
};

// hi + lo, if |a| >= |b|.
INLINE Extended quick_sum(const D& a, const D& b) {
  const D s = a + b;
  return {s, b - (s - a)};
}

// a + b without error.
INLINE Extended exact_sum(const D& a, const D& b) {
  const D s = a + b, v = s - a;
  return {s, (a - (s - v)) + (b - v)};
}

// a b without error.
INLINE Extended exact_product(const D& a, const D& b) {
  const D p = a * b;
  D e;
  for (int l = 0; l < W; ++l) e[l] = __builtin_fma(a[l], b[l], -p[l]);
  return {p, e};
}

INLINE Extended extend(const D& x) { return {x, D{}}; }

INLINE Extended operator-(const Extended& a) { return {-a.hi, -a.lo}; }
INLINE Extended operator+(const Extended& a, const Extended& b) {
  const Extended s = exact_sum(a.hi, b.hi), t = exact_sum(a.lo, b.lo);
  const Extended u = quick_sum(s.hi, s.lo + t.hi);
  return quick_sum(u.hi, u.lo + t.lo);
}
INLINE Extended operator-(const Extended& a, const Extended& b) { return a + -b; }
INLINE Extended operator*(const Extended& a, const Extended& b) {
  const Extended p = exact_product(a.hi, b.hi);
  return quick_sum(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
}
INLINE Extended operator*(const D& a, const Extended& b) {
  const Extended p = exact_product(a, b.hi);
  return quick_sum(p.hi, p.lo + a * b.lo);
}
INLINE Extended operator/(const Extended& a, const Extended& b) {
  const D first = a.hi / b.hi;
  const Extended left = a - first * b;
  return quick_sum(first, left.hi / b.hi);
}

INLINE Extended operator*(double a, const Extended& b) { return (D{} + a) * b; }
INLINE Extended operator*(const Extended& a, double b) { return (D{} + b) * a; }
INLINE Extended operator/(double a, const Extended& b) { return extend(D{} + a) / b; }
INLINE Extended operator-(double a, const Extended& b) { return extend(D{} + a) - b; }
INLINE Extended operator+(double a, const Extended& b) { return extend(D{} + a) + b; }
INLINE Extended operator+(const Extended& a, double b) { return a + extend(D{} + b); }
INLINE void operator+=(Extended& a, const Extended& b) { a = a + b; }
INLINE void operator-=(Extended& a, const Extended& b) { a = a - b; }

INLINE Mask operator<(const Extended& a, const Extended& b) {
  return (a.hi < b.hi) | ((a.hi == b.hi) & (a.lo < b.lo));
}
INLINE Mask operator<=(const Extended& a, const Extended& b) {
  return (a.hi < b.hi) | ((a.hi == b.hi) & (a.lo <= b.lo));
}
INLINE Mask operator>(const Extended& a, const Extended& b) { return b < a; }
INLINE Mask operator>=(const Extended& a, const Extended& b) { return b <= a; }
INLINE Mask operator<(const Extended& a, double b) { return a < extend(D{} + b); }
INLINE Mask operator<=(const Extended& a, double b) { return a <= extend(D{} + b); }
INLINE Mask operator>(const Extended& a, double b) { return extend(D{} + b) < a; }
INLINE Mask operator>=(const Extended& a, double b) { return extend(D{} + b) <= a; }

INLINE Extended select(const Mask& m, const Extended& a, const Extended& b) {
  return {m ? a.hi : b.hi, m ? a.lo : b.lo};
}

// The square root of numbers that are not negative.
INLINE Extended root(const Extended& x) {
  const D first = root(x.hi);
  const Extended left = x - exact_product(first, first);
  const D correction = first > 0.0 ? left.hi / (first + first) : first;
  return quick_sum(first, correction);
}

// Sets one of the two doubles in all lanes.
INLINE void put_part(Extended& x, int part, double value) { (part ? x.lo : x.hi) = D{} + value; }
INLINE double lane(const Extended& x, int l) { return x.hi[l]; }
INLINE double part_of(const Extended& x, int l, int part) { return (part ? x.lo : x.hi)[l]; }
INLINE void set_part(Extended& x, int l, int part, double value) {
  (part ? x.lo : x.hi)[l] = value;
}
INLINE void put(Extended& x, int l, double value) {
  x.hi[l] = value;
  x.lo[l] = 0.0;
}

}  // namespace
}  // namespace gsp
