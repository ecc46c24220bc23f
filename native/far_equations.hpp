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
  int second[kRows];  // where Q of each equation is that is a product; zero for others

  INLINE C number(int k) const {
    C z;
    __builtin_memcpy(&z.re, re + k * W, sizeof z.re);
    __builtin_memcpy(&z.im, im + k * W, sizeof z.im);
    return z;
  }
  FineNumbers numbers() const { return {{re, im}, {low_re, low_im}}; }
};

Block packed(const FarGeometry& g, const int* pose, double* work) {
  const int numbers = far_numbers(g.products), size = numbers * W;
  Block b{work, work + size, work + 2 * size, work + 3 * size, {}, {}, {}};
  for (int r = 0, at = kFarNumbers; r < kRows; ++r)
    if (g.products >> r & 1) b.second[r] = at, at += kOfProduct;
  for (int l = 0; l < W; ++l) {
    const int p = pose[l];
    b.doubt[l] = g.error[p], b.real[l] = g.real[p];
    for (int k = 0; k < numbers; ++k) {
      const Complex &x = g.number[p * numbers + k], &y = g.low[p * numbers + k];
      b.re[k * W + l] = x.re, b.im[k * W + l] = x.im;
      b.low_re[k * W + l] = y.re, b.low_im[k * W + l] = y.im;
    }
  }
  return b;
}

// A form, from its first number on, and its gradient.
INLINE void differentiate(const Block& b, int at, const C* s, C& value, C* gradient) {
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
  differentiate(b, kOfNorm * kLocalMonomials, s, norm, slope);
  for (int r = 0; r < kRows; ++r) {
    differentiate(b, r * kLocalMonomials, s, at.value[r], at.jacobian[r]);
    C by = shift[r];
    if (b.second[r]) {
      C q, along[kRows];
      differentiate(b, b.second[r], s, q, along);
      for (int k = 0; k < kRows; ++k)
        at.jacobian[r][k] = q * at.jacobian[r][k] + at.value[r] * along[k];
      at.value[r] = at.value[r] * q;
      by = (by + b.number(b.second[r] + kConstant)) * norm;
    }
    at.value[r] = at.value[r] - by * norm;
    const C twice = b.second[r] ? by + by : by;
    for (int k = 0; k < kRows; ++k) at.jacobian[r][k] = at.jacobian[r][k] - twice * slope[k];
  }
  invert(at.jacobian, at.inverse);
  return norm;
}

// Sums of the moduli of the terms of a form, of its derivatives, and of all second derivatives.
struct Sizes {
  V value, slope, curvature;
};

INLINE Sizes sizes_of(const Block& b, int at, const V* size) {
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

}  // namespace
}  // namespace gsp
