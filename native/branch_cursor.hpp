// The place of a branch while it is followed, and the values at this place.
//
// Included by branch_follower.cpp in each of its builds: all in an anonymous namespace, so that the
// linker cannot merge functions that were compiled for different processors.
#pragma once

#include "branch_follower.hpp"

#include <algorithm>
#include <cmath>

#include "segment_proof.hpp"

namespace gsp {
namespace {

// Segments that are followed before they are proved.
constexpr int kBlock = 8;
// Points before the last one that predict the next: on a parabola through two of them, or on the
// quartic through all, whichever predicted the last point better. Values have corners at rows.
constexpr int kBefore = 4;

// The place of a branch: at `row`, and `part` of 2^`level` equal steps to the next row.
struct Cursor {
  Branch* branch = nullptr;
  int row = 0, level = 0;
  std::int64_t part = 0;
  double z[N];
  double end = 0.0;    // a bound of the distance of the proved zero
  double alone = 0.0;  // a distance within which there is no other zero
  // The points before at the same step, the last one first.
  double before[kBefore][N];
  int known = 0;
  bool bent = false;  // whether the quartic predicts better
  int successes = 0;  // blocks in a row that were kept whole
  // The block that is being tried.
  int count = 0;
  double point[kBlock][N], from[kBlock][kConstraints], to[kBlock][kConstraints];
  double measure[kBlock], ends[kBlock], uniqueness[kBlock];
};

INLINE void value_at(const Branch& b, int row, std::int64_t part, int level, double* out) {
  const double* v = b.values + std::ptrdiff_t{row} * kConstraints;
  if (part == 0) {
    std::copy(v, v + kConstraints, out);
    return;
  }
  const double t = std::ldexp(static_cast<double>(part), -level);
  for (int k = 0; k < kConstraints; ++k) out[k] = v[k] + t * (v[k + kConstraints] - v[k]);
}

INLINE void advance(int& row, std::int64_t& part, int level) {
  if (++part == std::int64_t{1} << level) {
    part = 0;
    ++row;
  }
}

}  // namespace
}  // namespace gsp
