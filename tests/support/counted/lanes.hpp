// In the place of native/lanes.hpp: one lane of numbers that count the roundings behind them.
//
// A number is exact (k = 0), exactly zero (k = -1), or a sum of terms of which none goes through more
// than k roundings. Factors that are doubles and no powers of two are entries of Hessian matrices, which
// carry four.
#pragma once

#include <algorithm>
#include <cmath>

namespace gsp {
namespace {

constexpr int W = 1, N = 8;
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
};

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
  return {f * a.v, a.k + (std::fabs(std::frexp(f, &exponent)) == 0.5 ? 0 : 5)};
}
inline D operator*(const D& a, double f) { return f * a; }
inline D operator/(const D& a, const D& b) { return {a.v / b.v, std::max(a.k, 0) + std::max(b.k, 0) + 1}; }
inline D& operator+=(D& a, const D& b) { return a = a + b; }
inline D& operator-=(D& a, const D& b) { return a = a - b; }
inline D& operator*=(D& a, const D& b) { return a = a * b; }
inline bool operator<(const D& a, const D& b) { return a.v < b.v; }
inline bool operator>(const D& a, const D& b) { return a.v > b.v; }
inline D root(const D& a) { return {std::sqrt(a.v), a.k < 0 ? -1 : a.k + 1}; }
inline D splat(double x) { return x; }

}  // namespace
}  // namespace gsp
