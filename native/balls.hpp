// Numbers and vectors known to within a radius: operations add a bound of their own rounding error.
//
// Bounds are sums and products of nonnegative numbers, of fewer than 2^10 operations, and rounded
// outward at the end. Needs a compiler that neither contracts nor reorders (CMakeLists.txt).
#pragma once

#include <cmath>
#include <limits>

namespace gsp {

constexpr double kUnit = 0x1p-53;
constexpr double kOutward = 1.0 + 0x1p-40;
constexpr double kTiny = 0x1p-1000;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A number whose distance from m is at most r.
struct Ball {
  double m, r;
};

struct Vector {
  Ball c[3];
  Ball& operator[](int i) { return c[i]; }
  const Ball& operator[](int i) const { return c[i]; }
};

inline Ball rounded(double m, double r) {
  return {m, (r + std::abs(m) * kUnit + kTiny) * (1.0 + 0x1p-48)};
}
inline Ball operator+(const Ball& a, const Ball& b) { return rounded(a.m + b.m, a.r + b.r); }
inline Ball operator-(const Ball& a, const Ball& b) { return rounded(a.m - b.m, a.r + b.r); }
inline Ball operator-(const Ball& a) { return {-a.m, a.r}; }
inline Ball operator*(const Ball& a, const Ball& b) {
  return rounded(a.m * b.m, std::abs(a.m) * b.r + a.r * std::abs(b.m) + a.r * b.r);
}
inline Ball twice(const Ball& a) { return {2.0 * a.m, 2.0 * a.r}; }
inline double size(const Ball& a) { return std::abs(a.m) + a.r; }

// Not finite if the divisor may be zero.
inline Ball operator/(const Ball& a, const Ball& b) {
  const double least = std::abs(b.m) - b.r;
  if (!(least > 0.0)) return {0.0, kInfinity};
  const double q = a.m / b.m;
  return rounded(q, (a.r + std::abs(q) * b.r) / least);
}
inline Ball root(const Ball& a) {
  const double least = a.m - a.r;
  if (!(least > 0.0)) return {0.0, std::sqrt(size(a)) * kOutward};
  const double q = std::sqrt(a.m);
  return rounded(q, a.r / (q + std::sqrt(least)));
}

inline Ball dot(const Vector& a, const Vector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline Vector cross(const Vector& a, const Vector& b) {
  return {{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]}};
}
inline Vector operator+(const Vector& a, const Vector& b) {
  return {{a[0] + b[0], a[1] + b[1], a[2] + b[2]}};
}
inline Vector operator-(const Vector& a, const Vector& b) {
  return {{a[0] - b[0], a[1] - b[1], a[2] - b[2]}};
}
inline Vector operator-(const Vector& a) { return {{-a[0], -a[1], -a[2]}}; }
inline Vector operator*(const Ball& s, const Vector& a) {
  return {{s * a[0], s * a[1], s * a[2]}};
}
inline Vector twice(const Vector& a) { return {{twice(a[0]), twice(a[1]), twice(a[2])}}; }
inline double length(const Vector& a) {
  const double x = size(a[0]), y = size(a[1]), z = size(a[2]);
  return std::sqrt(x * x + y * y + z * z) * kOutward;
}
inline Vector across(const Vector& r, const Vector& axis) { return r - dot(axis, r) * axis; }
inline Vector vector(const Ball* b) { return {{b[0], b[1], b[2]}}; }

}  // namespace gsp
