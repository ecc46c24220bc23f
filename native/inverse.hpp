// Approximate inverses of Jacobian matrices, and what proofs in double precision allow for.
//
// Included by each build of ends.cpp and far_poses.cpp: all in an anonymous namespace, so that the linker
// cannot merge functions that were compiled for different processors.
#pragma once

#include "proofs.hpp"

#include "lanes.hpp"

namespace gsp {
namespace {

constexpr int kRows = kEquations + 1;
// As in gspcli.certification: bounds of the relative rounding error of everything computed here, of
// sums of nonnegative numbers, and of what falls below the normal range; radius of the theorem.
constexpr double kRounding = 0x1p-45, kOutward = 1.0 + 0x1p-40, kTiny = 0x1p-1000;
// Not below the modulus of z, and not much above it.
INLINE V bound(const C& z) { return maximum(z.re, -z.re) + maximum(z.im, -z.im); }

// An approximate inverse: J = L R by modified Gram-Schmidt, the rows of R orthogonal and the diagonal
// of L one, so J^-1 = R^H (R R^H)^-1 L^-1.
void invert(const C (&jacobian)[kRows][kRows], C (&inverse)[kRows][kRows]) {
  C r[kRows][kRows], lower[kRows][kRows], x[kRows][kRows];
  V scale[kRows];
  for (int i = 0; i < kRows; ++i)
    for (int k = 0; k < kRows; ++k) r[i][k] = jacobian[i][k];
  for (int j = 0; j < kRows; ++j) {
    V size = square(r[j][0]);
    for (int k = 1; k < kRows; ++k) size += square(r[j][k]);
    scale[j] = 1.0 / size;
    for (int i = j + 1; i < kRows; ++i) {
      Sum sum{};
      for (int k = 0; k < kRows; ++k) sum.add(r[j][k], r[i][k]);
      const C s = scale[j] * sum.conjugate_total();
      for (int k = 0; k < kRows; ++k) subtract_product(r[i][k], s, r[j][k]);
      lower[i][j] = s;
    }
  }
  for (int c = 0; c < kRows; ++c) {
    x[c][c] = {splat(1.0), splat(0.0)};
    for (int i = c + 1; i < kRows; ++i) {
      x[i][c] = C{};
      for (int j = c; j < i; ++j) subtract_product(x[i][c], lower[i][j], x[j][c]);
    }
    for (int i = c; i < kRows; ++i) x[i][c] = scale[i] * x[i][c];
  }
  for (int k = 0; k < kRows; ++k)
    for (int c = 0; c < kRows; ++c) {
      Sum sum{};
      for (int j = c; j < kRows; ++j) sum.add(r[j][k], x[j][c]);
      inverse[k][c] = sum.conjugate_total();
    }
}

}  // namespace
}  // namespace gsp
