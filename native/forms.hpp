// Products of the terms of two series in e: all e_i e_j (i <= j, row by row), with N among them.
//
// Included by each build of tracker.cpp and reduced_homotopy.cpp: all in an anonymous namespace, so that the
// linker cannot merge functions that were compiled for different processors.
#pragma once

#include "lanes.hpp"

namespace gsp {
namespace {

// A product, alone or added to s.
template <bool alone>
INLINE void take_product(C& s, const C& a, const C& b) {
  if constexpr (alone)
    s = a * b;
  else
    add_product(s, a, b);
}

// The products of x with itself, alone or added to others.
template <bool alone>
INLINE void take_square(C* ee, const C* x) {
  for (int i = 0, n = 0; i < 4; ++i)
    for (int j = i; j < 4; ++j) take_product<alone>(ee[n++], x[i], x[j]);
}

// The products of x with y and of y with x, likewise.
template <bool alone>
INLINE void take_both(C* ee, const C* x, const C* y) {
  for (int i = 0, n = 0; i < 4; ++i) {
    take_product<alone>(ee[n++], x[i] + x[i], y[i]);
    for (int j = i + 1; j < 4; ++j, ++n) {
      C s = ee[n];
      take_product<alone>(s, x[i], y[j]);
      add_product(s, x[j], y[i]);
      ee[n] = s;
    }
  }
}

INLINE C norm_form(const C* ee) { return ee[0] + ee[4] + ee[7] + ee[9]; }

}  // namespace
}  // namespace gsp
