// Functions of the pose over a box, enclosed by their Taylor forms. A form has the value at the
// centre, the sum of the moduli of the derivatives times the half widths, and a bound of the rest
// (pose_box.hpp). So the enclosure differs from the range only by terms of second order.
//
// A function is given by its wrench, the derivatives by the position (force) and by a rotation about
// the pivot (moment). For the square of a distance without rotation the enclosure is the range itself.
#pragma once

#include <algorithm>
#include <cmath>

#include "pose_box.hpp"

namespace gsp {

struct Range {
  double low, high;
};

// A function at the centre, its wrench, and bounds of the rest.
struct Form {
  Ball value;
  Vector force, moment;
  double below, above;
};

inline Range range(const Form& f, const Place& at) {
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
inline Range square_over_box(const Placed& b, const Place& at) {
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

inline Form point_point(const Placed& b) {
  return {dot(b.r, b.r), twice(b.r), twice(cross(b.y, b.s)), 2.0 * b.r_size * b.bend,
          2.0 * b.r_size * b.bend + b.reach * b.reach};
}

// The distance along a turning direction, w . r.
inline Form along(const Vector& w, const Placed& b, const Place& at) {
  const double rough = at.shift * at.rho + b.s_size * at.bend;
  return {dot(w, b.r), w, cross(w, b.s), rough, rough};
}

inline Form point_plane(const Placed& b) { return {dot(b.v, b.r), b.v, cross(b.y, b.v), b.bend, b.bend}; }

}  // namespace gsp
