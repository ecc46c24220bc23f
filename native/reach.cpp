// Proves that all poses of a box keep the limits, or that all violate one.
//
// Each function of the pose that a limit is about is enclosed over the box (box_forms.hpp).
#include <algorithm>
#include <cmath>

#include "box_forms.hpp"
#include "drives.hpp"

namespace gsp {
namespace {

Form point_line(const Placed& b) {
  const Vector q = across(b.r, b.v);
  const double rough = 2.0 * length(q) * b.bend;
  return {dot(q, q), twice(q), twice(cross(b.y, q)), rough, rough + b.reach * b.reach};
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

// Whether the axis of a cone rotates with an arm.
bool turns(const Cone& cone, const Swing& swing) {
  return swing.drive && !swing.drive->slide && swing.drive->of_platform != cone.of_base;
}

// The axis of a cone in the frame of its body when the motor is at its place at the centre of the box.
Vector axis_at(const Cone& cone, const Swing& swing) {
  const Vector axis = vector(cone.axis);
  if (!turns(cone, swing)) return axis;
  const Vector n = vector(swing.drive->axis), along = dot(n, axis) * n;
  const Ball c{std::cos(swing.q), kTrigonometry}, s{std::sin(swing.q), kTrigonometry};
  return along + c * (axis - along) + s * cross(n, axis);
}

// Bounds the change of f of judge_cone when the motor moves from its place at the centre, at any
// pose of the box. With the axis a, the derivative of f by q is a' . r + a . r' less the cosine
// times r' . r / |r|.
double change_by_motor(const Cone& cone, const Placed& b, const Swing& swing, const Place& at,
                       const Vector& axis, const Vector& direction) {
  const Drive& drive = *swing.drive;
  const bool turning = turns(cone, swing);
  const Vector a = cone.of_base ? axis : at.turned(axis);
  const Vector v = drive.of_platform ? swing.rate : -swing.rate;
  const double fast = length(v), cosine = size(cone.cosine);
  Ball slope = dot(a, v);
  double turn_of_axis = cone.of_base ? 0.0 : at.rho;
  const double moves = b.reach + fast * swing.delta + swing.bend;
  double varies = 0.0;
  if (turning) {
    const Vector n = vector(drive.axis);
    const Vector rate = cross(cone.of_base ? n : at.turned(n), a);
    slope = slope + dot(rate, b.r);
    turn_of_axis += swing.delta;
    varies += moves + (b.r_size + moves) * turn_of_axis;
  }
  // Of a platform's motor r' turns, too.
  const double bends = (drive.slide ? 0.0 : fast * swing.delta) + (drive.of_platform ? at.rho * fast : 0.0);
  const double far = length(b.r);
  varies += (fast + bends) * turn_of_axis + bends;
  varies += cosine * (bends + (fast + bends) * 2.0 * moves / (far * (1.0 - 0x1p-30)));
  const Ball whole = cone.of_base ? slope : -slope;
  return (size(whole - cone.cosine * dot(direction, v)) + varies) * swing.delta * kOutward;
}

// The axis times the leg, less the cosine times its length, is at least zero.
Verdict judge_cone(const Cone& cone, const Placed& b, const Swing& swing, const Place& at) {
  const Ball far = root(dot(b.r, b.r));
  const double least = far.m - far.r;
  if (!(least > 0.0)) return Verdict::kOpen;
  const Vector direction = {{b.r[0] / far, b.r[1] / far, b.r[2] / far}};
  const Vector axis = axis_at(cone, swing);
  Form f;
  if (cone.of_base)
    f = {dot(axis, b.r), axis, cross(b.y, axis), b.bend, b.bend};
  else
    f = negative(along(at.turned(axis), b, at));
  // |r| is at least its linear part, and exceeds it by at most d^2 / 2 |r0| for a motion d.
  const double linear = size(cone.cosine) * b.bend;
  const double curved = size(cone.cosine) * b.reach * b.reach / (2.0 * least);
  f.value = f.value - cone.cosine * far;
  f.force = f.force - cone.cosine * direction;
  f.moment = f.moment - cone.cosine * cross(b.y, direction);
  f.below += linear + (cone.cosine.m + cone.cosine.r > 0.0 ? curved : 0.0);
  f.above += linear + (cone.cosine.m - cone.cosine.r < 0.0 ? curved : 0.0);
  if (swing.drive) {
    const double moves = change_by_motor(cone, b, swing, at, axis, direction);
    f.below += moves;
    f.above += moves;
  }
  return at_least_zero(range(f, at));
}

}  // namespace

Verdict judge(const Reach& reach, const double* centre, const double* half, Conditions& open,
              Whole* whole) {
  const Place at = place(reach, centre, half);
  Placed legs[32];
  const int count = static_cast<int>(reach.limit.size());
  const int cones = static_cast<int>(reach.cone.size());
  Conditions of_drives = kNegative;
  for (std::size_t k = 0; k < reach.drive.size(); ++k) {
    const Drive& drive = reach.drive[k];
    const Limit& limit = reach.limit[drive.row];
    of_drives |= conditions_of(drive.row);
    if (!(open & conditions_of(drive.row))) continue;
    const Verdict found =
        whole ? judge_drive(DriveJudge(*whole->drive[k], limit, at), drive.row, open)
              : judge_drive(DriveJudge(drive, limit, at), drive.row, open);
    if (found == Verdict::kOutside) return found;
  }
  if (!(open & ~of_drives)) return open & ~kNegative ? Verdict::kOpen : Verdict::kInside;
  Swing swing[6];
  Conditions driven = 0, unknown = 0;
  for (const Drive& drive : reach.drive) driven |= Conditions{1} << drive.row;
  Conditions needed = open & ~driven;
  for (int j = 0; j < cones; ++j)
    if (open >> (count + j) & 1) needed |= Conditions{1} << reach.cone[j].leg;
  for (const Drive& drive : reach.drive) {
    const int k = drive.row;
    if (((needed >> k & 1) || (open & kRegular)) &&
        !locate(drive, reach.limit[k], at, legs[k], swing[k]))
      unknown |= Conditions{1} << k;
  }
  for (int k = 0; k < count; ++k)
    if (((needed >> k & 1) || (open & kRegular)) && !(driven >> k & 1))
      legs[k] = placed(reach.limit[k], at);
  for (int k = 0; k < count + cones; ++k) {
    const Conditions bit = Conditions{1} << k;
    if (!(open & bit) || (driven & bit)) continue;
    if (k >= count && (unknown >> reach.cone[k - count].leg & 1)) continue;
    const Verdict found = k < count
                              ? judge_range(reach.limit[k], legs[k], at)
                              : judge_cone(reach.cone[k - count], legs[reach.cone[k - count].leg],
                                          swing[reach.cone[k - count].leg], at);
    if (found == Verdict::kOutside) return found;
    if (found == Verdict::kInside) open &= ~bit;
  }
  if ((open & kRegular) && !unknown)
    if (const int sign = regular(reach, legs, swing, at)) {
      open &= ~kRegular;
      if (sign < 0) open |= kNegative;
    }
  return open & ~kNegative ? Verdict::kOpen : Verdict::kInside;
}

}  // namespace gsp
