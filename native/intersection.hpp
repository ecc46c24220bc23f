// Common points of planes and quadrics of projective 3-space: the interface of the builds of
// intersection.cpp, one for each instruction set. Nothing here but plain data, as in tracker.hpp.
//
// A plane is a vector p of length 4, its equation p.z = 0; a quadric is a symmetric matrix Q of
// order 4, its equation z^T Q z = 0. By Bezout's theorem n quadrics and 3 - n planes meet in 2^n
// points counted with multiplicity, or in infinitely many.
#pragma once

#include "tracker.hpp"

namespace gsp {

// Systems of k planes and 3 - k quadrics each, in groups of some that share their quadrics.
struct Intersections {
  int groups, systems;     // systems of each group
  const Complex* plane;    // (groups, systems, k, 4)
  const Complex* quadric;  // (groups, 3 - k, 4, 4), symmetric
  const double* accuracy;  // (groups): relative errors of both
  const bool* real;        // (groups): whether planes and quadrics are real
};

// Arrays over the systems. Points of real systems are real or in pairs of conjugates, one directly
// after the other. Where a system has not been solved, points are zero and errors infinite.
struct IntersectionResults {
  Complex* point;  // (2^(3-k), 4), norm 1
  double* error;   // (2^(3-k)): estimated distance of each from the exact point
  bool* ok;        // whether there are 2^(3-k) accurate points that are well apart
};

using Intersect = void(const Intersections&, int planes, const IntersectionResults&);

Intersect intersect_portable, intersect_avx2, intersect_avx512;

}  // namespace gsp
