#include "pose_box.hpp"

#include <cmath>

namespace gsp {
namespace {

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

}  // namespace

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

}  // namespace gsp
