// Proves that no pose of a box is singular. The rows of the Jacobian matrix J are enclosed over the
// box, and C is an approximate inverse of J at the centre. If |1 - C J| < 1 in the norm of row sums
// for all enclosed J, none is singular.
#include <algorithm>
#include <cmath>

#include "pose_box.hpp"

namespace gsp {
namespace {

// Encloses a vector over the box.
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

// A row of J, up to a factor: moment about the pivot, and force.
void wrench(const Limit& limit, const Placed& centre, const Swing& swing, const Place& at, Ball* row) {
  Vector y = spread(centre.y, nullptr, at, true), s = spread(centre.s, at.h, at, false);
  const Vector w = spread(centre.w, nullptr, at, true), &v = centre.v;
  if (swing.drive) {
    Vector& moving = swing.drive->of_platform ? y : s;
    for (int i = 0; i < 3; ++i)
      moving[i].r = (moving[i].r + size(swing.rate[i]) * swing.delta + swing.bend) * kOutward;
  }
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
      // The derivative of the distance m / s, times s^3: s^2 m' + m c c', where c is the cosine and
      // s the sine.
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

// Computes an approximate inverse. Returns the sign of the determinant, 0 if a pivot is zero.
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

}  // namespace

int regular(const Reach& reach, const Placed* b, const Swing* swing, const Place& at) {
  Ball row[6][6];
  double centre[6][6], inverse[6][6];
  for (int k = 0; k < 6; ++k) {
    wrench(reach.limit[k], b[k], swing[k], at, row[k]);
    for (int j = 0; j < 6; ++j) centre[k][j] = row[k][j].m;
  }
  const int sign = invert(centre, inverse);
  if (sign == 0) return 0;
  // Rows and columns of C J belong to components of the twist. A unit of length is chosen for which
  // rotations and translations have the same size.
  double turn = 0.0, move = 0.0;
  for (int k = 0; k < 6; ++k)
    for (int j = 0; j < 3; ++j) {
      turn = std::max(turn, std::abs(inverse[j][k]));
      move = std::max(move, std::abs(inverse[3 + j][k]));
    }
  const double scale = turn > 0.0 && move > 0.0 ? move / turn : 1.0;
  // |1 - C J|, with the rounding errors of 6 products and of the identity.
  for (int i = 0; i < 6; ++i) {
    double sum = 0.0;
    for (int j = 0; j < 6; ++j) {
      double c = i == j ? 1.0 : 0.0, rough = c * kUnit * 16;
      for (int k = 0; k < 6; ++k) {
        const double a = std::abs(inverse[i][k]);
        c -= inverse[i][k] * row[k][j].m;
        rough += a * (row[k][j].r + std::abs(row[k][j].m) * kUnit * 16);
      }
      // In that unit of length.
      const double unit = (i < 3) == (j < 3) ? 1.0 : (i < 3 ? scale : 1.0 / scale);
      sum += (std::abs(c) + rough) * unit;
    }
    if (!(sum * kOutward < 1.0)) return 0;
  }
  return sign;
}

}  // namespace gsp
