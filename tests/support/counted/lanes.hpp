// In the place of native/lanes.hpp: numbers that count the roundings behind them.
//
// A number is exact (k = 0), exactly zero (k = -1), or a sum of terms of which none goes through more
// than k roundings. Factors that are doubles and no powers of two are entries of Hessian matrices, which
// carry COUNTED_ENTRY. A number is as long as two doubles: so a lane of two is one.
#pragma once

#include <algorithm>
#include <cmath>

#ifndef COUNTED_ENTRY
#define COUNTED_ENTRY 4
#endif
#ifndef COUNTED_LANES
#define COUNTED_LANES 1
#endif

namespace gsp {
namespace {

constexpr int W = COUNTED_LANES, N = 8;
typedef bool Mask;
#define INLINE inline
#define NOINLINE

struct D {
  double v = 0.0;
  int k = -1;
  D() = default;
  D(double x) : v(x), k(x == 0.0 ? -1 : 0) {}
  D(double x, int roundings) : v(x), k(roundings) {}
  // Of a cosine: as many as of the square of a value.
  struct Lane {
    D& of;
    void operator=(double x) { of = D(x, 9); }
    operator double() const { return of.v; }
  };
  Lane operator[](int) { return {*this}; }
  double operator[](int) const { return v; }
  explicit operator bool() const { return v != 0.0; }
};
static_assert(sizeof(D) == 2 * sizeof(double));

inline D operator-(const D& a) { return {-a.v, a.k}; }
inline D operator+(const D& a, const D& b) {
  if (a.k < 0) return b;
  return b.k < 0 ? a : D(a.v + b.v, std::max(a.k, b.k) + 1);
}
inline D operator-(const D& a, const D& b) { return a + -b; }
inline D operator*(const D& a, const D& b) {
  return a.k < 0 || b.k < 0 ? D() : D(a.v * b.v, a.k + b.k + 1);
}
inline D operator*(double f, const D& a) {
  if (f == 0.0 || a.k < 0) return {};
  int exponent;
  return {f * a.v, a.k + (std::fabs(std::frexp(f, &exponent)) == 0.5 ? 0 : COUNTED_ENTRY + 1)};
}
inline D operator*(const D& a, double f) { return f * a; }
inline D operator/(const D& a, const D& b) { return {a.v / b.v, std::max(a.k, 0) + std::max(b.k, 0) + 1}; }
inline D& operator+=(D& a, const D& b) { return a = a + b; }
inline D& operator-=(D& a, const D& b) { return a = a - b; }
inline D& operator*=(D& a, const D& b) { return a = a * b; }
inline bool operator<(const D& a, const D& b) { return a.v < b.v; }
inline bool operator>(const D& a, const D& b) { return a.v > b.v; }
inline bool operator<=(const D& a, const D& b) { return a.v <= b.v; }
inline D root(const D& a) { return {std::sqrt(a.v), a.k < 0 ? -1 : a.k + 1}; }
inline D splat(double x) { return x; }
inline D select(Mask m, const D& a, const D& b) { return m ? a : b; }
inline D minimum(const D& a, const D& b) { return a.v < b.v ? a : b; }
inline D maximum(const D& a, const D& b) { return D(std::max(a.v, b.v), std::max(a.k, b.k)); }

typedef D V;
struct C {
  V re, im;
};
inline int count(const C& a) { return std::max(a.re.k, a.im.k); }
inline C operator+(const C& a, const C& b) { return {a.re + b.re, a.im + b.im}; }
inline C operator-(const C& a, const C& b) { return {a.re - b.re, a.im - b.im}; }
inline C operator*(const C& a, const C& b) { return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re}; }
inline C operator*(const V& a, const C& b) { return {a * b.re, a * b.im}; }
inline C by(const D& a, const C& b) { return a * b; }
inline void add_product(C& s, const C& a, const C& b) {
  s.re += a.re * b.re;
  s.re -= a.im * b.im;
  s.im += a.re * b.im;
  s.im += a.im * b.re;
}
template <class Number>
inline void add_product(C& s, const Number& a, const C& b) {
  add_product(s, C{a.re, a.im}, b);
}
inline void subtract_product(C& s, const C& a, const C& b) {
  s.re -= a.re * b.re;
  s.re += a.im * b.im;
  s.im -= a.re * b.im;
  s.im -= a.im * b.re;
}
struct Sum {
  V same_re, same_im, mixed, mixed_too;
  void add(const C& a, const C& b) {
    same_re += a.re * b.re;
    same_im += a.im * b.im;
    mixed += a.re * b.im;
    mixed_too += a.im * b.re;
  }
  C total() const { return {same_re - same_im, mixed + mixed_too}; }
  C conjugate_total() const { return {same_re + same_im, mixed - mixed_too}; }
};
inline V square(const C& a) { return a.re * a.re + a.im * a.im; }
inline C select(Mask m, const C& a, const C& b) { return m ? a : b; }

}  // namespace
}  // namespace gsp
