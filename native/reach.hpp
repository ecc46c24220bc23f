// Which poses in a box of poses keep the limits of a platform: ranges of values, cones of joints.
//
// A pose is a position p of the pivot and a rotation E from home, E = A1 A2 A3 with rotations about
// axes of the base by three angles. Everything of the platform is given about the pivot, turned as it
// is at home, so that a point is p + E y and a direction E u. Plain data, no Python.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace gsp {

// Numbers and vectors known to within a radius: operations add a bound of their own rounding error.
//
// Bounds are sums and products of nonnegative numbers, of fewer than 2^10 operations, and rounded
// outward at the end. Needs a compiler that neither contracts nor reorders (CMakeLists.txt).

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

constexpr int kParameters = 6;  // x, y, z and three angles, in this order

// What is measured; the squares of the first three.
enum class Measure : std::int32_t {
  kPointPoint = 0,
  kPointLine = 1,
  kLinePoint = 2,
  kPointPlane = 3,  // signed, towards the normal
  kPlanePoint = 4,
  kLineLine = 5,    // of the square, multiplied by that of the sine
  kDirections = 6,  // the cosine
};

struct Limit {
  Measure measure;
  bool modulus;     // compare that of a signed distance
  Ball y[3], u[3];  // point and unit direction of the platform
  Ball x[3], v[3];  // of the base
  Ball low, high;   // of what is measured; infinite if all values are allowed on that side
};

// Directions of a leg that makes an angle with an axis of which the cosine is at least this.
struct Cone {
  int leg;
  bool of_base;
  Ball axis[3];
  Ball cosine;
};

// A motor that moves one of the two points of a limit. A crank moves it on a circle, middle + along
// cos q + beside sin q, a slide on a line, middle + along q. Both are in the frame of the point's
// body.
struct Drive {
  int row;                // the limit, of points
  bool slide, of_platform;
  double working_mode;            // the sign of the derivative of the distance by q, the gain: 1 or -1
  Ball middle[3], along[3], beside[3], axis[3];
  Vector first, last;      // the point at the ends of the range,
  Ball low, high;          // and the range, if the condition of the limit is open
  double at_low[2], at_high[2];  // cosine and sine of both
  Ball square;             // of the distance, which is constant
};

struct Reach {
  std::vector<Limit> limit;
  std::vector<Cone> cone;
  std::vector<Drive> drive;
  int turn[3];  // the axes (0 to 2) of A1, A2, A3
};

// Conditions by bits: ranges (of the motor where a limit has one), then cones, then for each motor that
// the rod reaches its point, then regularity. Beside them the sign of the determinant of the Jacobian
// matrix, once all of it are proved to be regular.
using Conditions = std::uint32_t;
constexpr Conditions kReach = Conditions{1} << 18;
constexpr Conditions kRegular = Conditions{1} << 31;
constexpr Conditions kNegative = Conditions{1} << 30;

enum class Verdict { kInside, kOutside, kOpen };

struct Whole;  // drives.hpp

// Judges the poses with parameters within `half` of `centre`. Conditions that hold for all of them are
// removed from `open`, and the sign is added. Outside: all poses violate one condition. `whole` is a
// box that this one is a part of, or null.
Verdict judge(const Reach& reach, const double* centre, const double* half, Conditions& open,
              Whole* whole);

// Labels of boxes that are connected: boxes of a grid that was halved `level` times in each of
// `dimensions` directions, with coordinates of 64 / dimensions bits packed in keys. Through faces, or,
// if `touching`, also through edges and corners; then the ends of `periodic` directions are the same
// place, and so are all boxes at either end of the direction `poles` (-1: none).
std::vector<std::int64_t> connected(const std::uint64_t* keys, const std::int32_t* levels,
                                    std::size_t count, int dimensions, bool touching,
                                    const bool* periodic, int poles);

}  // namespace gsp
