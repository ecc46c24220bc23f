// Vectors of quadruple-double numbers: an unevaluated sum of four doubles has 64 digits.
//
// Sums and products after Y. Hida, X. S. Li, D. H. Bailey (Algorithms for quad-double precision
// floating point arithmetic, 2001), without branches: terms that are too small are omitted without
// a test. Results are not rounded correctly; some bits of the 212 are lost. As in double_double.hpp
// nothing may be reassociated.
//
// Functions are not inlined: each takes hundreds of operations on all lanes. Included by lanes.hpp:
// in an anonymous namespace, as everything there.
#pragma once

#include "double_double.hpp"

namespace gsp {
namespace {

struct QuadDouble {
  static constexpr int kParts = 4;
  D part[4];
  QuadDouble() = default;
  explicit INLINE QuadDouble(const D& x) : part{x, D{}, D{}, D{}} {}
  INLINE QuadDouble(const D& a, const D& b, const D& c, const D& d) : part{a, b, c, d} {}
  // Vector by vector, as C in lanes.hpp.
  INLINE QuadDouble(const QuadDouble& o) : part{o.part[0], o.part[1], o.part[2], o.part[3]} {}
  INLINE QuadDouble& operator=(const QuadDouble& o) {
    for (int k = 0; k < 4; ++k) part[k] = o.part[k];
    return *this;
  }
};

// Makes the parts overlap by no bits, as far as two passes do.
INLINE QuadDouble renormalized(D a, D b, D c, D d) {
  for (int pass = 0; pass < 2; ++pass) {
    DoubleDouble s = exact_sum(c, d);
    c = s.hi, d = s.lo;
    s = exact_sum(b, c);
    b = s.hi, c = s.lo;
    s = exact_sum(a, b);
    a = s.hi, b = s.lo;
  }
  DoubleDouble s = exact_sum(b, c);
  b = s.hi, c = s.lo;
  s = exact_sum(c, d);
  return {a, b, s.hi, s.lo};
}

INLINE QuadDouble operator-(const QuadDouble& a) {
  return {-a.part[0], -a.part[1], -a.part[2], -a.part[3]};
}

// a plus b.
NOINLINE void add(const QuadDouble& a, const QuadDouble& b, QuadDouble& out) {
  const DoubleDouble s0 = exact_sum(a.part[0], b.part[0]), s1 = exact_sum(a.part[1], b.part[1]),
                 s2 = exact_sum(a.part[2], b.part[2]);
  const DoubleDouble t1 = exact_sum(s1.hi, s0.lo);
  const DoubleDouble t2 = exact_sum(s2.hi, s1.lo);
  const DoubleDouble u2 = exact_sum(t2.hi, t1.lo);
  const D rest = (a.part[3] + b.part[3]) + (s2.lo + (t2.lo + u2.lo));
  out = renormalized(s0.hi, t1.hi, u2.hi, rest);
}

// a times b.
NOINLINE void multiply(const QuadDouble& a, const QuadDouble& b, QuadDouble& out) {
  const DoubleDouble p00 = exact_product(a.part[0], b.part[0]);
  const DoubleDouble p01 = exact_product(a.part[0], b.part[1]),
                 p10 = exact_product(a.part[1], b.part[0]);
  const DoubleDouble p02 = exact_product(a.part[0], b.part[2]),
                 p11 = exact_product(a.part[1], b.part[1]),
                 p20 = exact_product(a.part[2], b.part[0]);
  // Of the second order: three numbers, and what their sum loses.
  const DoubleDouble x = exact_sum(p01.hi, p10.hi), y = exact_sum(x.hi, p00.lo);
  const DoubleDouble z = exact_sum(x.lo, y.lo);
  // Of the third order: six numbers.
  const DoubleDouble s = exact_sum(p02.hi, p20.hi), t = exact_sum(p01.lo, p10.lo);
  const DoubleDouble u = exact_sum(s.hi, t.hi), v = exact_sum(p11.hi, z.hi);
  const DoubleDouble w = exact_sum(u.hi, v.hi);
  const D rest = ((a.part[0] * b.part[3] + a.part[3] * b.part[0]) +
                  (a.part[1] * b.part[2] + a.part[2] * b.part[1])) +
                 ((p02.lo + p20.lo) + p11.lo) + (s.lo + t.lo) + (u.lo + v.lo) + (w.lo + z.lo);
  out = renormalized(p00.hi, y.hi, w.hi, rest);
}

// a times b, of a double.
NOINLINE void multiply(const D& a, const QuadDouble& b, QuadDouble& out) {
  const DoubleDouble p0 = exact_product(a, b.part[0]), p1 = exact_product(a, b.part[1]),
                 p2 = exact_product(a, b.part[2]);
  const DoubleDouble x = exact_sum(p1.hi, p0.lo);
  const DoubleDouble y = exact_sum(p2.hi, p1.lo), z = exact_sum(y.hi, x.lo);
  out = renormalized(p0.hi, x.hi, z.hi, a * b.part[3] + (p2.lo + (y.lo + z.lo)));
}

INLINE QuadDouble operator+(const QuadDouble& a, const QuadDouble& b) {
  QuadDouble c;
  add(a, b, c);
  return c;
}
INLINE QuadDouble operator*(const QuadDouble& a, const QuadDouble& b) {
  QuadDouble c;
  multiply(a, b, c);
  return c;
}
INLINE QuadDouble operator*(const D& a, const QuadDouble& b) {
  QuadDouble c;
  multiply(a, b, c);
  return c;
}

// Each step of the long division finds the digits of one double.
NOINLINE void divide(const QuadDouble& a, const QuadDouble& b, QuadDouble& out) {
  QuadDouble left = a;
  D digits[4];
  for (int k = 0; k < 4; ++k) {
    digits[k] = left.part[0] / b.part[0];
    if (k < 3) left = left - digits[k] * b;
  }
  out = renormalized(digits[0], digits[1], digits[2], digits[3]);
}
INLINE QuadDouble operator/(const QuadDouble& a, const QuadDouble& b) {
  QuadDouble c;
  divide(a, b, c);
  return c;
}

// The square root of numbers that are not negative, by Newton's method with a fixed derivative.
NOINLINE void take_root(const QuadDouble& x, QuadDouble& out) {
  const D first = root(x.part[0]);
  const D slope = first > 0.0 ? 0.5 / first : first;
  out = QuadDouble(first);
  for (int k = 0; k < 3; ++k) {
    const QuadDouble left = x - out * out;
    out = out + slope * left;
  }
}
INLINE QuadDouble root(const QuadDouble& x) {
  QuadDouble c;
  take_root(x, c);
  return c;
}

INLINE Mask operator<(const QuadDouble& a, const QuadDouble& b) {
  const QuadDouble left = a - b;
  return left.part[0] < 0.0;
}
INLINE Mask operator<=(const QuadDouble& a, const QuadDouble& b) {
  const QuadDouble left = a - b;
  return left.part[0] <= 0.0;
}

INLINE QuadDouble select(const Mask& m, const QuadDouble& a, const QuadDouble& b) {
  return {m ? a.part[0] : b.part[0], m ? a.part[1] : b.part[1], m ? a.part[2] : b.part[2],
          m ? a.part[3] : b.part[3]};
}

// Sets one of the four doubles in all lanes.
INLINE void put_part(QuadDouble& x, int part, double value) { x.part[part] = D{} + value; }
INLINE double lane(const QuadDouble& x, int l) { return x.part[0][l]; }
INLINE double part_of(const QuadDouble& x, int l, int part) { return x.part[part][l]; }
INLINE void set_part(QuadDouble& x, int l, int part, double value) { x.part[part][l] = value; }
INLINE void put(QuadDouble& x, int l, double value) {
  x.part[0][l] = value;
  for (int k = 1; k < 4; ++k) x.part[k][l] = 0.0;
}

}  // namespace
}  // namespace gsp
