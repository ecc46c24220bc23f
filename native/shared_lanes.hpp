// Numbers of all lanes in memory, for code that is built for other processors, and their low parts.
//
// Included by ends.cpp and far_poses.cpp in each of their builds: all in an anonymous namespace, so that
// the linker cannot merge functions that were compiled for different processors.
#pragma once

#include "fine_points.hpp"
#include "inverse.hpp"

namespace gsp {
namespace {

// Numbers of all lanes as other builds of code can read them.
template <int count>
struct Shared {
  double re[count * W], im[count * W];

  void store(const C* z) {
    for (int i = 0; i < count; ++i) {
      __builtin_memcpy(re + i * W, &z[i].re, sizeof z[i].re);
      __builtin_memcpy(im + i * W, &z[i].im, sizeof z[i].im);
    }
  }
  void load(C* z) const {
    for (int i = 0; i < count; ++i) {
      __builtin_memcpy(&z[i].re, re + i * W, sizeof z[i].re);
      __builtin_memcpy(&z[i].im, im + i * W, sizeof z[i].im);
    }
  }
  operator LaneNumbers() { return {re, im}; }
};

// hi + low -= change
INLINE void subtract(V& hi, V& low, const V& change) {
  const V t = low - change, s = hi + t, v = s - hi;
  low = (hi - (s - v)) + (t - v);
  hi = s;
}

}  // namespace
}  // namespace gsp
