// The equations of poses far away in their local coordinates, in lanes, and their Jacobian matrices.
//
// Included by far_poses.cpp in each of its builds: all in an anonymous namespace, so that the linker
// cannot merge functions that were compiled for different processors.
#pragma once

#include "far_poses.hpp"

#include "inverse.hpp"

namespace gsp {
namespace {

// The numbers of a pose for each lane: number k of lane l stands at k W + l.
struct Block {
  double *re, *im, *low_re, *low_im;
  double doubt[W], real[W];

  INLINE C number(int k) const {
    C z;
    __builtin_memcpy(&z.re, re + k * W, sizeof z.re);
    __builtin_memcpy(&z.im, im + k * W, sizeof z.im);
    return z;
  }
  FineNumbers numbers() const { return {{re, im}, {low_re, low_im}}; }
};

Block packed(const FarGeometry& g, const int* pose, double* work) {
  constexpr int size = kFarNumbers * W;
  Block b{work, work + size, work + 2 * size, work + 3 * size, {}, {}};
  for (int l = 0; l < W; ++l) {
    const int p = pose[l];
    b.doubt[l] = g.error[p], b.real[l] = g.real[p];
    for (int k = 0; k < kFarNumbers; ++k) {
      const Complex &x = g.number[p * kFarNumbers + k], &y = g.low[p * kFarNumbers + k];
      b.re[k * W + l] = x.re, b.im[k * W + l] = x.im;
      b.low_re[k * W + l] = y.re, b.low_im[k * W + l] = y.im;
    }
  }
  return b;
}

struct Linear {
  C value[kRows], jacobian[kRows][kRows], inverse[kRows][kRows];
};

// A form and its gradient.
INLINE void differentiate(const Block& b, int form, const C* s, C& value, C* gradient) {
  int at = form * kLocalMonomials;
  value = b.number(at++);
  for (int i = 0; i < kRows; ++i, ++at) {
    gradient[i] = b.number(at);
    add_product(value, gradient[i], s[i]);
  }
  for (int i = 0; i < kRows; ++i)
    for (int j = i; j < kRows; ++j, ++at) {
      const C q = b.number(at), by = q * s[j];
      add_product(value, by, s[i]);
      gradient[i] = gradient[i] + by;
      add_product(gradient[j], q, s[i]);
    }
}

// The shift of each equation (7) for values further by a shift (6).
INLINE void mix(const Block& b, const Complex* shift, C* mixed) {
  for (int i = 0, k = kMixed; i < kRows; ++i) {
    mixed[i] = C{};
    for (int r = 0; r < kEquations; ++r, ++k) add_product(mixed[i], shift[r], b.number(k));
  }
}

// The equations, shifted; returns N.
C linearize(const Block& b, const C* shift, const C* s, Linear& at) {
  C norm, slope[kRows];
  differentiate(b, kOfNorm, s, norm, slope);
  for (int r = 0; r < kRows; ++r) {
    differentiate(b, r, s, at.value[r], at.jacobian[r]);
    at.value[r] = at.value[r] - shift[r] * norm;
    for (int k = 0; k < kRows; ++k) at.jacobian[r][k] = at.jacobian[r][k] - shift[r] * slope[k];
  }
  invert(at.jacobian, at.inverse);
  return norm;
}

// Sums of the moduli of the terms of a form, of its derivatives, and of all second derivatives.
struct Sizes {
  V value, slope, curvature;
};

INLINE Sizes sizes_of(const Block& b, int form, const V* size) {
  int at = form * kLocalMonomials;
  Sizes sum{bound(b.number(at++)), splat(0.0), splat(0.0)};
  for (int i = 0; i < kRows; ++i, ++at) {
    const V a = bound(b.number(at));
    sum.value += a * size[i], sum.slope += a;
  }
  for (int i = 0; i < kRows; ++i)
    for (int j = i; j < kRows; ++j, ++at) {
      const V a = bound(b.number(at));
      sum.value += a * size[i] * size[j], sum.slope += a * (size[i] + size[j]), sum.curvature += 2.0 * a;
    }
  return sum;
}

INLINE void newton_step(const Linear& at, C* change) {
  for (int i = 0; i < kRows; ++i) {
    change[i] = C{};
    for (int j = 0; j < kRows; ++j) add_product(change[i], at.inverse[i][j], at.value[j]);
  }
}

}  // namespace
}  // namespace gsp
