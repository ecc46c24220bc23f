// Distances of convex hulls of points, bounded from both sides.
#pragma once

namespace gsp {

// A lower and an upper bound of the distance of two hulls; both are NaN if a coordinate is NaN.
struct Gap {
  double low, high;
};

// The distance of the hulls of m and n points, three coordinates each. The bounds allow for errors of
// coordinates of 2^-46 of the largest one.
Gap hull_gap(const double* a, int m, const double* b, int n);

}  // namespace gsp
