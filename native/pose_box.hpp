// A box of poses: its centre, and how far the vectors of the constraints move within the box.
//
// Let h be the half widths of the position, d_i those of the angles, and rho the sum of the d_i.
// Along a straight line of parameters the angular velocity is at most rho. The angular acceleration
// is at most the sum of the d_i d_j (i < j), which is at most rho^2 / 3. So a turning vector E y
// moves by at most rho |y|, and differs from its linear part by at most (rho^2 + rho^2 / 3) |y| / 2
// = 2/3 rho^2 |y|.
//
// The cosine and sine of the C library are taken to be exact to 2^-50.
#pragma once

#include "reach.hpp"

namespace gsp {

// Of the cosine and sine of the C library.
constexpr double kTrigonometry = 0x1p-50;

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

Place place(const Reach& reach, const double* centre, const double* half);

// The vectors of a limit at the centre: s from the base's point to the pivot, r to the platform's.
struct Placed {
  Vector s, r, y, w, v;
  double y_size, r_size, s_size;
  double reach;  // how far r moves
  double bend;   // how far r differs from its linear part
};

inline Placed placed_points(const Vector& y, const Vector& x, const Place& at) {
  Placed b;
  b.y = y;
  b.s = at.p - x;
  b.r = b.s + b.y;
  b.y_size = length(b.y);
  b.r_size = length(b.r);
  b.s_size = length(b.s);
  b.reach = at.shift + at.rho * b.y_size;
  b.bend = at.bend * b.y_size;
  return b;
}

inline Placed placed(const Limit& limit, const Place& at) {
  Placed b = placed_points(at.turned(vector(limit.y)), vector(limit.x), at);
  b.v = vector(limit.v);
  b.w = limit.measure == Measure::kPointPoint ? Vector{} : at.turned(vector(limit.u));
  return b;
}

// How the point of a motor moves in the box: by at most `delta` times its rate at the centre, and `bend`.
struct Swing {
  const Drive* drive = nullptr;  // none: the point does not move
  double q, delta, bend;
  Vector rate;  // turned as at the centre
};

// The sign of the determinant of the Jacobian matrix if no pose of the box is singular, else 0.
int regular(const Reach& reach, const Placed* b, const Swing* swing, const Place& at);

}  // namespace gsp
