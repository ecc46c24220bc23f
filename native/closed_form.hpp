// All poses of platforms with three distances and three angles (Algorithm 6.6), if they are in
// general position: first the rotations, then at each the translations. Plain data.
//
// An angle constraint is linear in R, so times N = e.e it is a real quadric in the quaternion space
// P^3. Three of them in general position meet in eight points, and none has N = 0 (Section 6.1,
// Proposition 6.1). The translations that meet the distances are computed in surfaces.hpp.
#pragma once

#include "intersection.hpp"
#include "surfaces.hpp"

namespace gsp {

constexpr int kAngles = 3;
constexpr int kRotations = 8;

// Directions of the angles on the platform and on the base, (3, 3) each.
struct Directions {
  const double* u;
  const double* v;
};

// Sets of values: cosines R u . v, heights and lengths, of which there are as many as `Measures` has.
struct ValueSets {
  int count;
  const double* cosine;  // (count, 3)
  const double* flat;    // (count, heights)
  const double* curved;  // (count, squares)
};

// How many poses each set has in general position on each combination of sides.
int poses_of(const Measures&);

// Returns Study points of any norm of all poses of each set (count, signs, poses, 8); those of real
// poses are exactly real. Also whether the set is in general position: then there are no other
// poses, by Bezout's theorem. If not, the points are zero.
void solve_closed_forms(const Directions&, const Measures&, const ValueSets&, Intersect* intersect,
                        std::complex<double>* point, bool* general);

}  // namespace gsp
