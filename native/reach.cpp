// Proves that all poses of a box keep the limits, or that all violate one.
//
// Over a box each function f of the pose that a limit is about is enclosed by its Taylor form: its value
// at the centre, the sum of the moduli of its derivatives times the half widths, and a bound of the
// rest (pose_box.hpp), so that the enclosure differs from the range by terms of second order only.
//
// A function is given by its wrench, the derivatives by the position (force) and by a rotation about
// the pivot (moment). For the square of a distance without rotation the enclosure is the range itself.
#include <algorithm>
#include <cmath>

#include "pose_box.hpp"

namespace gsp {
namespace {

struct Range {
  double low, high;
};

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

}  // namespace gsp
