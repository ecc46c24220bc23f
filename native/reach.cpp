// Proves that all poses of a box keep the limits, or that all violate one.
//
// Over a box each function f of the pose that a limit is about is enclosed by its Taylor form: its value
// at the centre, the sum of the moduli of its derivatives times the half widths, and a bound of the
// rest, so that the enclosure differs from the range by terms of second order only. With the half
// widths h of the position and d_i of the angles, rho the sum of the d_i: along a straight line of
// parameters the angular velocity is at most rho and the angular acceleration at most the sum of the
// d_i d_j (i < j), at most rho^2 / 3. So a turning vector E y moves by at most rho |y|, and differs
// from its linear part by at most (rho^2 + rho^2 / 3) |y| / 2 = 2/3 rho^2 |y|.
//
// A function is given by its wrench, the derivatives by the position (force) and by a rotation about
// the pivot (moment). For the square of a distance without rotation the enclosure is the range itself.
//
// Regular: the rows of the Jacobian matrix J are enclosed over the box; with C an approximate inverse of
// that of the centre, |1 - C J| < 1 in the norm of row sums for all of them, so no J is singular.
//
// Rounding: values are balls, whose operations add a bound of their own rounding error. Bounds are
// sums and products of nonnegative numbers, of fewer than 2^10 operations, and rounded outward at the
// end. The cosine and sine of the C library are taken to be exact to 2^-50.
#include "reach.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace gsp {
namespace {

constexpr double kUnit = 0x1p-53;
constexpr double kOutward = 1.0 + 0x1p-40;
constexpr double kTiny = 0x1p-1000;
constexpr double kTrigonometry = 0x1p-50;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

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

struct Range {
  double low, high;
};

// The centre of a box, and how far the box reaches from it.
struct Place {
  Vector p;
  double h[3], d[3];
  double shift;  // the length of h
  double rho, bend;
  bool tilted;       // whether the centre itself is turned from home
  // Only if the box has other rotations than that of home:
  Vector column[3];  // of E
  Vector axis[3];    // of the derivatives by the angles

  Vector turned(const Vector& a) const {
    if (rho == 0.0 && !tilted) return a;
    Vector b;
    for (int i = 0; i < 3; ++i)
      b[i] = column[0][i] * a[0] + column[1][i] * a[1] + column[2][i] * a[2];
    return b;
  }
};

void rotate(Vector& a, int axis, const Ball& c, const Ball& s) {
  const int i = (axis + 1) % 3, j = (axis + 2) % 3;
  const Ball x = c * a[i] - s * a[j], y = s * a[i] + c * a[j];
  a[i] = x;
  a[j] = y;
}

Vector unit(int axis) {
  Vector e{};
  e[axis].m = 1.0;
  return e;
}

Place place(const Reach& reach, const double* centre, const double* half) {
  Place at;
  double square = 0.0;
  at.rho = 0.0;
  at.tilted = false;
  for (int i = 0; i < 3; ++i) {
    at.p[i] = {centre[i], 0.0};
    at.h[i] = half[i];
    at.d[i] = half[3 + i];
    square += half[i] * half[i];
    at.rho += half[3 + i];
    at.tilted = at.tilted || centre[3 + i] != 0.0;
  }
  at.shift = std::sqrt(square) * kOutward;
  at.rho *= kOutward;
  at.bend = 2.0 / 3.0 * at.rho * at.rho * kOutward;
  if (at.rho == 0.0 && !at.tilted) return at;
  Ball c[3], s[3];
  for (int i = 0; i < 3; ++i) {
    c[i] = {std::cos(centre[3 + i]), kTrigonometry};
    s[i] = {std::sin(centre[3 + i]), kTrigonometry};
  }
  for (int i = 0; i < 3; ++i) {
    at.column[i] = unit(i);
    for (int k = 2; k >= 0; --k) rotate(at.column[i], reach.turn[k], c[k], s[k]);
    at.axis[i] = unit(reach.turn[i]);
    for (int k = i - 1; k >= 0; --k) rotate(at.axis[i], reach.turn[k], c[k], s[k]);
  }
  return at;
}

// The vectors of a limit at the centre: s from the base's point to the pivot, r to the platform's.
struct Placed {
  Vector s, r, y, w, v;
  double y_size, r_size, s_size;
  double reach;  // how far r moves
  double bend;   // how far it is off its linear part
};

Placed placed(const Limit& limit, const Place& at) {
  Placed b;
  b.y = at.turned(vector(limit.y));
  b.s = at.p - vector(limit.x);
  b.r = b.s + b.y;
  b.v = vector(limit.v);
  b.w = limit.measure == Measure::kPointPoint ? Vector{} : at.turned(vector(limit.u));
  b.y_size = length(b.y);
  b.r_size = length(b.r);
  b.s_size = length(b.s);
  b.reach = at.shift + at.rho * b.y_size;
  b.bend = at.bend * b.y_size;
  return b;
}

// A function at the centre, its wrench, and bounds of the rest.
struct Form {
  Ball value;
  Vector force, moment;
  double below, above;
};

Range range(const Form& f, const Place& at) {
  double slope = 0.0;
  for (int i = 0; i < 3; ++i) {
    if (at.h[i] != 0.0) slope += size(f.force[i]) * at.h[i];
    if (at.d[i] != 0.0) slope += size(dot(at.axis[i], f.moment)) * at.d[i];
  }
  const double least = slope + f.below + f.value.r, most = slope + f.above + f.value.r;
  return {f.value.m - least * kOutward - std::abs(f.value.m) * kUnit * 4,
          f.value.m + most * kOutward + std::abs(f.value.m) * kUnit * 4};
}

// The square of the distance of points over the box in which r lies.
Range square_over_box(const Placed& b, const Place& at) {
  Range sum{0.0, 0.0};
  for (int i = 0; i < 3; ++i) {
    double half = at.h[i] + b.r[i].r;
    if (at.rho != 0.0) {
      double turns = b.bend;
      for (int k = 0; k < 3; ++k)
        if (at.d[k] != 0.0) turns += size(cross(at.axis[k], b.y)[i]) * at.d[k];
      half += turns;
    }
    half *= kOutward;
    const double near = std::max(std::abs(b.r[i].m) - half, 0.0), far = std::abs(b.r[i].m) + half;
    sum.low += near * near;
    sum.high += far * far;
  }
  return {sum.low * (1.0 - 0x1p-40), sum.high * kOutward};
}

Form point_point(const Placed& b) {
  return {dot(b.r, b.r), twice(b.r), twice(cross(b.y, b.s)), 2.0 * b.r_size * b.bend,
          2.0 * b.r_size * b.bend + b.reach * b.reach};
}

Form point_line(const Placed& b) {
  const Vector q = across(b.r, b.v);
  const double rough = 2.0 * length(q) * b.bend;
  return {dot(q, q), twice(q), twice(cross(b.y, q)), rough, rough + b.reach * b.reach};
}

// The distance along a turning direction, w . r.
Form along(const Vector& w, const Placed& b, const Place& at) {
  const double rough = at.shift * at.rho + b.s_size * at.bend;
  return {dot(w, b.r), w, cross(w, b.s), rough, rough};
}

Form line_point(const Placed& b, const Place& at) {
  const Form g = along(b.w, b, at);
  const Vector q = across(b.r, b.w);
  const double moves = at.shift + b.s_size * at.rho;
  const double rough = 2.0 * (b.r_size * b.bend + size(g.value) * g.above);
  const Ball factor = twice(g.value);
  return {dot(q, q), twice(b.r) - factor * b.w, twice(cross(b.y, b.s)) - factor * g.moment,
          rough + moves * moves, rough + b.reach * b.reach};
}

Form point_plane(const Placed& b) { return {dot(b.v, b.r), b.v, cross(b.y, b.v), b.bend, b.bend}; }

Form directions(const Placed& b, const Place& at) {
  return {dot(b.w, b.v), Vector{}, cross(b.w, b.v), at.bend, at.bend};
}

Form negative(const Form& f) { return {-f.value, -f.force, -f.moment, f.above, f.below}; }

// m^2 - c s^2 with the moment m and the sine s of two lines.
Form line_line(const Ball& c, const Placed& b, const Place& at) {
  const Vector n = cross(b.w, b.v);
  const Ball m = dot(b.r, n);
  const Vector turning = cross(b.y, n) + cross(b.w, cross(b.v, b.r));
  const double rough = b.bend + b.r_size * at.bend + b.reach * at.rho;
  const double moves = b.reach + b.r_size * at.rho + b.reach * at.rho;
  const double sine = 2.0 * length(n) * at.bend;
  const Vector of_sine = twice(cross(b.w, cross(b.v, n)));
  const Ball factor = twice(m);
  return {m * m - c * dot(n, n), factor * n, factor * turning - c * of_sine,
          2.0 * size(m) * rough + size(c) * (sine + at.rho * at.rho),
          2.0 * size(m) * rough + moves * moves + size(c) * sine};
}

Verdict compare(const Range& range, const Ball& low, const Ball& high) {
  if (range.low >= low.m + low.r && range.high <= high.m - high.r) return Verdict::kInside;
  if (range.high < low.m - low.r || range.low > high.m + high.r) return Verdict::kOutside;
  return Verdict::kOpen;
}

Verdict at_least_zero(const Range& range) {
  if (range.low >= 0.0) return Verdict::kInside;
  return range.high < 0.0 ? Verdict::kOutside : Verdict::kOpen;
}

Verdict judge_range(const Limit& limit, const Placed& b, const Place& at) {
  Range found;
  switch (limit.measure) {
    case Measure::kPointPoint: {
      found = square_over_box(b, at);
      if (at.rho != 0.0) {
        const Range other = range(point_point(b), at);
        found = {std::max(found.low, other.low), std::min(found.high, other.high)};
      }
      break;
    }
    case Measure::kPointLine:
      found = range(point_line(b), at);
      break;
    case Measure::kLinePoint:
      found = range(line_point(b, at), at);
      break;
    case Measure::kPointPlane:
      found = range(point_plane(b), at);
      break;
    case Measure::kPlanePoint:
      found = range(negative(along(b.w, b, at)), at);
      break;
    case Measure::kLineLine: {
      const Verdict more = std::isinf(limit.low.m)
                               ? Verdict::kInside
                               : at_least_zero(range(line_line(limit.low, b, at), at));
      const Verdict less = at_least_zero(range(negative(line_line(limit.high, b, at)), at));
      if (more == Verdict::kOutside || less == Verdict::kOutside) return Verdict::kOutside;
      return more == less ? more : Verdict::kOpen;
    }
    default:
      found = range(directions(b, at), at);
  }
  if (limit.modulus) {
    const double least = std::max({found.low, -found.high, 0.0});
    found = {least, std::max(-found.low, found.high)};
  }
  return compare(found, limit.low, limit.high);
}

// The axis times the leg, less the cosine times its length, is at least zero.
Verdict judge_cone(const Cone& cone, const Placed& b, const Place& at) {
  const Ball far = root(dot(b.r, b.r));
  const double least = far.m - far.r;
  if (!(least > 0.0)) return Verdict::kOpen;
  const Vector direction = {{b.r[0] / far, b.r[1] / far, b.r[2] / far}};
  Form f;
  if (cone.of_base) {
    const Vector axis = vector(cone.axis);
    f = {dot(axis, b.r), axis, cross(b.y, axis), b.bend, b.bend};
  } else {
    f = negative(along(at.turned(vector(cone.axis)), b, at));
  }
  // |r| is at least its linear part, and exceeds it by at most d^2 / 2 |r0| for a motion d.
  const double linear = size(cone.cosine) * b.bend;
  const double curved = size(cone.cosine) * b.reach * b.reach / (2.0 * least);
  f.value = f.value - cone.cosine * far;
  f.force = f.force - cone.cosine * direction;
  f.moment = f.moment - cone.cosine * cross(b.y, direction);
  f.below += linear + (cone.cosine.m + cone.cosine.r > 0.0 ? curved : 0.0);
  f.above += linear + (cone.cosine.m - cone.cosine.r < 0.0 ? curved : 0.0);
  return at_least_zero(range(f, at));
}

// A vector with all its values in the box.
Vector spread(const Vector& a, const double* shift, const Place& at, bool turning) {
  Vector b = a;
  const double rough = at.bend * length(a);
  for (int i = 0; i < 3; ++i) {
    double more = shift ? shift[i] : 0.0;
    if (turning && at.rho != 0.0) {
      more += rough;
      for (int k = 0; k < 3; ++k)
        if (at.d[k] != 0.0) more += size(cross(at.axis[k], a)[i]) * at.d[k];
    }
    b[i].r = (b[i].r + more) * kOutward;
  }
  return b;
}

// The moment about the pivot and the force of what a constraint measures, up to a factor.
void wrench(const Limit& limit, const Placed& centre, const Place& at, Ball* row) {
  const Vector y = spread(centre.y, nullptr, at, true), w = spread(centre.w, nullptr, at, true);
  const Vector s = spread(centre.s, at.h, at, false), &v = centre.v;
  const Vector r = s + y;
  Vector force{}, moment{};
  switch (limit.measure) {
    case Measure::kPointPoint:
      force = r;
      moment = cross(y, s);
      break;
    case Measure::kPointLine:
      force = across(r, v);
      moment = cross(y, force);
      break;
    case Measure::kLinePoint: {
      const Ball g = dot(w, r);
      force = r - g * w;
      moment = cross(y, s) - g * cross(w, s);
      break;
    }
    case Measure::kPointPlane:
      force = v;
      moment = cross(y, v);
      break;
    case Measure::kPlanePoint:
      force = w;
      moment = cross(w, s);
      break;
    case Measure::kLineLine: {
      // Of m / s, times s^3: s^2 m' + m c c' with the cosine c.
      const Vector n = cross(w, v);
      const Ball square = dot(n, n), m = dot(r, n), c = dot(w, v);
      force = square * n;
      moment = square * (cross(y, n) + cross(w, cross(v, r))) + (m * c) * n;
      break;
    }
    default:
      moment = cross(w, v);
  }
  for (int i = 0; i < 3; ++i) {
    row[i] = moment[i];
    row[3 + i] = force[i];
  }
}

// An approximate inverse; the sign of the determinant, 0 if there is none.
int invert(double (*a)[6], double (*inverse)[6]) {
  int sign = 1;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) inverse[i][j] = i == j ? 1.0 : 0.0;
  for (int k = 0; k < 6; ++k) {
    int pivot = k;
    for (int i = k + 1; i < 6; ++i)
      if (std::abs(a[i][k]) > std::abs(a[pivot][k])) pivot = i;
    if (!(std::abs(a[pivot][k]) > 0.0)) return 0;
    if ((pivot != k) != (a[pivot][k] < 0.0)) sign = -sign;
    if (pivot != k) {
      std::swap_ranges(a[k], a[k] + 6, a[pivot]);
      std::swap_ranges(inverse[k], inverse[k] + 6, inverse[pivot]);
    }
    const double scale = 1.0 / a[k][k];
    for (int j = 0; j < 6; ++j) {
      a[k][j] *= scale;
      inverse[k][j] *= scale;
    }
    for (int i = 0; i < 6; ++i) {
      const double f = a[i][k];
      if (i == k || f == 0.0) continue;
      for (int j = 0; j < 6; ++j) {
        a[i][j] -= f * a[k][j];
        inverse[i][j] -= f * inverse[k][j];
      }
    }
  }
  return sign;
}

// The sign of the determinant if no pose of the box is singular, else 0.
int regular(const Reach& reach, const Placed* b, const Place& at) {
  Ball row[6][6];
  double centre[6][6], inverse[6][6];
  for (int k = 0; k < 6; ++k) {
    wrench(reach.limit[k], b[k], at, row[k]);
    for (int j = 0; j < 6; ++j) centre[k][j] = row[k][j].m;
  }
  const int sign = invert(centre, inverse);
  if (sign == 0) return 0;
  // Rows of C J belong to components of the twist; those of the rotation are measured by the others.
  double turn = 0.0, move = 0.0;
  for (int k = 0; k < 6; ++k)
    for (int j = 0; j < 3; ++j) {
      turn = std::max(turn, std::abs(inverse[j][k]));
      move = std::max(move, std::abs(inverse[3 + j][k]));
    }
  const double scale = turn > 0.0 && move > 0.0 ? move / turn : 1.0;
  // Less the rounding of the products, of 6 terms and the identity.
  for (int i = 0; i < 6; ++i) {
    double sum = 0.0;
    for (int j = 0; j < 6; ++j) {
      double c = i == j ? 1.0 : 0.0, rough = c * kUnit * 16;
      for (int k = 0; k < 6; ++k) {
        const double a = std::abs(inverse[i][k]);
        c -= inverse[i][k] * row[k][j].m;
        rough += a * (row[k][j].r + std::abs(row[k][j].m) * kUnit * 16);
      }
      // With the unit of length chosen so that both sorts of components are alike.
      const double unit = (i < 3) == (j < 3) ? 1.0 : (i < 3 ? scale : 1.0 / scale);
      sum += (std::abs(c) + rough) * unit;
    }
    if (!(sum * kOutward < 1.0)) return 0;
  }
  return sign;
}

}  // namespace

Verdict judge(const Reach& reach, const double* centre, const double* half, Conditions& open) {
  const Place at = place(reach, centre, half);
  Placed legs[32];
  const int count = static_cast<int>(reach.limit.size());
  const int cones = static_cast<int>(reach.cone.size());
  Conditions needed = open;
  for (int j = 0; j < cones; ++j)
    if (open >> (count + j) & 1) needed |= Conditions{1} << reach.cone[j].leg;
  for (int k = 0; k < count; ++k)
    if ((needed >> k & 1) || (open & kRegular)) legs[k] = placed(reach.limit[k], at);
  for (int k = 0; k < count + cones; ++k) {
    const Conditions bit = Conditions{1} << k;
    if (!(open & bit)) continue;
    const Verdict found = k < count
                              ? judge_range(reach.limit[k], legs[k], at)
                              : judge_cone(reach.cone[k - count], legs[reach.cone[k - count].leg], at);
    if (found == Verdict::kOutside) return found;
    if (found == Verdict::kInside) open &= ~bit;
  }
  if (open & kRegular)
    if (const int sign = regular(reach, legs, at)) {
      open &= ~kRegular;
      if (sign < 0) open |= kNegative;
    }
  return open & ~kNegative ? Verdict::kOpen : Verdict::kInside;
}

namespace {

// Sets that are merged.
class Partition {
 public:
  explicit Partition(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), std::int64_t{0});
  }
  std::int64_t find(std::int64_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void merge(std::int64_t i, std::int64_t j) {
    i = find(i);
    j = find(j);
    if (i != j) parent_[std::max(i, j)] = std::min(i, j);
  }

 private:
  std::vector<std::int64_t> parent_;
};

// Where boxes of one level are in the list: a table with open addressing.
class Level {
 public:
  void reserve(std::size_t count) {
    if (!count) return;
    std::size_t size = 4;
    while (size < 2 * count) size *= 2;
    boxes_.assign(size, {0, -1});
  }
  bool empty() const { return boxes_.empty(); }
  void insert(std::uint64_t key, std::int64_t index) {
    std::size_t i = hash(key);
    while (boxes_[i].second >= 0) i = (i + 1) & (boxes_.size() - 1);
    boxes_[i] = {key, index};
  }
  std::int64_t find(std::uint64_t key) const {
    if (boxes_.empty()) return -1;
    for (std::size_t i = hash(key);; i = (i + 1) & (boxes_.size() - 1))
      if (boxes_[i].second < 0 || boxes_[i].first == key) return boxes_[i].second;
  }

 private:
  std::size_t hash(std::uint64_t key) const {
    key = (key ^ (key >> 31)) * 0x9E3779B97F4A7C15u;
    return (key ^ (key >> 32)) & (boxes_.size() - 1);
  }
  std::vector<std::pair<std::uint64_t, std::int64_t>> boxes_;
};

}  // namespace

std::vector<std::int64_t> connected(const std::uint64_t* keys, const std::int32_t* levels,
                                    std::size_t count, int dimensions, bool touching,
                                    const bool* periodic, int poles) {
  const int bits = 64 / dimensions;
  const std::uint64_t mask = bits == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << bits) - 1;
  std::vector<Level> grid(64);
  std::vector<std::size_t> counts(64);
  for (std::size_t i = 0; i < count; ++i) ++counts[levels[i]];
  for (int l = 0; l < 64; ++l) grid[l].reserve(counts[l]);
  for (std::size_t i = 0; i < count; ++i)
    grid[levels[i]].insert(keys[i], static_cast<std::int64_t>(i));
  std::vector<int> used;
  for (int l = 63; l >= 0; --l)
    if (!grid[l].empty()) used.push_back(l);
  Partition parts(count);
  std::int64_t at_poles[2] = {-1, -1};
  int steps = 1;
  for (int d = 0; d < dimensions; ++d) steps *= 3;
  for (std::size_t i = 0; i < count; ++i) {
    const int level = levels[i];
    const std::int64_t side = std::int64_t{1} << level;
    std::int64_t place[8];
    for (int d = 0; d < dimensions; ++d)
      place[d] = static_cast<std::int64_t>(keys[i] >> (d * bits) & mask);
    if (touching && poles >= 0)
      for (int end = 0; end < 2; ++end)
        if (place[poles] == (end ? side - 1 : 0)) {
          if (at_poles[end] >= 0) parts.merge(at_poles[end], static_cast<std::int64_t>(i));
          at_poles[end] = static_cast<std::int64_t>(i);
        }
    for (int step = 0; step < steps; ++step) {
      std::int64_t next[8];
      int moved = 0;
      bool exists = true;
      for (int d = 0, rest = step; d < dimensions; ++d, rest /= 3) {
        const int by = rest % 3 - 1;
        moved += by != 0;
        next[d] = place[d] + by;
        if (next[d] < 0 || next[d] >= side) {
          if (touching && periodic[d]) next[d] = (next[d] + side) % side;
          else exists = false;
        }
      }
      if (!exists || moved == 0 || (!touching && moved > 1)) continue;
      // Boxes of the same parent are no larger.
      bool sibling = true;
      for (int d = 0; d < dimensions; ++d) sibling = sibling && next[d] >> 1 == place[d] >> 1;
      for (const int other : used) {
        if (other > level) continue;
        if (other < level && sibling) break;
        std::uint64_t key = 0;
        for (int d = 0; d < dimensions; ++d)
          key |= static_cast<std::uint64_t>(next[d] >> (level - other)) << (d * bits);
        const std::int64_t j = grid[other].find(key);
        if (j >= 0) {
          parts.merge(static_cast<std::int64_t>(i), j);
          break;
        }
      }
    }
  }
  std::vector<std::int64_t> labels(count);
  for (std::size_t i = 0; i < count; ++i) labels[i] = parts.find(static_cast<std::int64_t>(i));
  return labels;
}

}  // namespace gsp
