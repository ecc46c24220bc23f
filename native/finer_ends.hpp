// Poses proved with 64 digits, near points of any number of digits; plain data.
//
// Poses far away are at points where the equations are nearly dependent and N nearly vanishes. There
// the theorem of gspcli.certification.poses.isolation needs values of the equations with 64 digits; for
// their derivatives and the inverse of these 32 digits are enough.
#pragma once

#include <cstdint>

#include "fine_points.hpp"
#include "proofs.hpp"

namespace gsp {

// A platform: its equations, and bounds of their coefficients (quadrics, 27), which err by less than 2^-190 times
// these.
struct FinerPlatform {
  FinerQuadrics equations;
  const double* bound;
  OwnFrames frames;  // of the points
  double scale;      // what lengths are multiplied by in the end, a power of two
  double tolerance;  // largest deviation of a pose, relative to its largest entry if above one
};

// Arrays over the points, as `Poses` (ends.hpp) has them.
struct FinerPoses {
  Complex *rotation, *translation, *quaternion;
  double* deviation;
  std::uint8_t* proved;
  Complex* reached;  // (4, count, 8): the points that Newton's method has reached, in the frames of the equations
};

// Decides about `count` points (parts, count, 8), sums of up to four numbers each. `work` has room for the
// moduli of the Hessian matrices.
using DecideFiner = void(const FinerPlatform&, int parts, int count, const Complex* points, double* work,
                         const FinerPoses&);
DecideFiner decide_finer_portable, decide_finer_avx2, decide_finer_avx512;

}  // namespace gsp
