// Approximate inverses of Jacobian matrices, and what proofs in double precision allow for.
//
// Included by each build of ends.cpp and far_poses.cpp: all in an anonymous namespace, so that the linker
// cannot merge functions that were compiled for different processors.
#pragma once

#include "proofs.hpp"

#include "factorization.hpp"
#include "lanes.hpp"

namespace gsp {
namespace {

constexpr int kRows = kEquations + 1;
// As in gspcli.certification: bounds of the relative rounding error of everything computed here (with 16 or
// with 32 digits), of sums of nonnegative doubles, and of what falls below the normal range.
constexpr double kRounding = GSP_PARTS == 1 ? 0x1p-45 : 0x1p-90, kOutward = 1.0 + 0x1p-40, kTiny = 0x1p-1000;
// Relative error of a step of Newton's method where nothing cancels.
constexpr double kStepRounding = 0x1p-48;

#if GSP_PARTS == 1
INLINE D leading(const V& x) { return x; }
#else
INLINE D leading(const V& x) { return x.hi; }
INLINE D select(const Mask& m, const D& a, const D& b) { return m ? a : b; }
INLINE D minimum(const D& a, const D& b) { return a < b ? a : b; }
INLINE D maximum(const D& a, const D& b) { return a > b ? a : b; }
#endif
INLINE D size_of(const V& x) { return maximum(leading(x), -leading(x)); }
// An upper bound of the modulus of z up to rounding, not much above it.
INLINE D bound(const C& z) { return size_of(z.re) + size_of(z.im); }

#if GSP_PARTS == 1
// Equations at a point: values and derivatives, with an approximate inverse there or near there.
struct Linear {
  C value[kRows], jacobian[kRows][kRows], inverse[kRows][kRows];
};

INLINE void newton_step(const Linear& at, C* change) {
  for (int i = 0; i < kRows; ++i) {
    change[i] = C{};
    for (int j = 0; j < kRows; ++j) add_product(change[i], at.inverse[i][j], at.value[j]);
  }
}

// An approximate inverse: J = L R, so J^-1 = R^H (R R^H)^-1 L^-1.
void invert(const C (&jacobian)[kRows][kRows], C (&inverse)[kRows][kRows]) {
  C r[kRows][kRows], lower[kRows][kRows], x[kRows][kRows];  // x: the columns of (R R^H)^-1 L^-1
  V scale[kRows];
  for (int i = 0; i < kRows; ++i)
    for (int k = 0; k < kRows; ++k) r[i][k] = jacobian[i][k];
  factorize<kRows>(r, lower, scale);
  for (int c = 0; c < kRows; ++c) {
    inverse_column<kRows>(lower, c, x[c]);
    for (int i = c; i < kRows; ++i) x[c][i] = scale[i] * x[c][i];
  }
  for (int k = 0; k < kRows; ++k)
    for (int c = 0; c < kRows; ++c) {
      Sum sum{};
      for (int j = c; j < kRows; ++j) sum.add(r[j][k], x[c][j]);
      inverse[k][c] = sum.conjugate_total();
    }
}
#endif

}  // namespace
}  // namespace gsp
