// From the ends of paths to proved poses, for many sets of values of one geometry; plain data.
//
// The theorem and the bounds are those of gspcli.certification.poses.isolation, the equations those of
// gspcli.certification.poses.many_values: a value changes how often N is in its equation.
#pragma once

#include <cstdint>

#include "fine_points.hpp"
#include "proofs.hpp"

namespace gsp {

// A geometry with its values left open.
struct OpenGeometry {
  ProofSystem equations;       // with distances and cosines of zero
  const double* weight;        // (6) of the value in how often N is in the main quadric
  const double* weight_bound;  // (6) see `Doubled` in open_equations.hpp
  const double* norm_bound;    // (6) of how often N is there without the value
  const std::int32_t* turned;  // (6) the quadric that is multiplied by the distance; -1: none
  // The points' own frames and unit: f becomes unit f + (base e - e platform) / 2.
  double unit;
  double base[3], platform[3];
  double scale;      // what lengths are multiplied by in the end, a power of two
  double tolerance;  // largest deviation of a pose, relative to its largest entry if above one
  // For values of equations with 32 digits.
  const double *hessian_low, *weight_low;
};

// One set of values. `value` is the function in the equation (a square, the distance, a cosine),
// `bound` bounds it, `distance` is the distance itself where a quadric is turned. `low` and
// `distance_low` are the remainders after rounding value and distance to doubles, and `gap` bounds
// the error of `value` + `low`.
struct OpenValues {
  const double *value, *bound, *distance, *low, *gap, *distance_low;  // (6) each
  double unit;  // of the digits of translations, a power of two, in lengths of the equations
};

// Arrays over the points of one set of values.
struct Poses {
  Complex* rotation;     // (count, 9)
  Complex* translation;  // (count, 3)
  Complex* quaternion;   // (count, 4), e.e = 1, see `poses.canonical_sign`
  double* deviation;     // of the pose in any entry, translations divided by the scale
  std::uint8_t* proved;  // bits of `Proved`; no bit unless the deviation is tolerable
  // Whether all are proved (isolated, and real or not), and different.
  std::uint8_t* complete;
};

// Decides about `count` Study points of any norm (count, 8) after one step of Newton's method. If
// that does not suffice, more steps follow at points of 32 digits. Poses are in doubles then
// (FinePoints). `work` has room for twice the Hessian matrices and the coefficients, 182 quadrics
// numbers, and for 3 numbers a point.
using Decide = void(const OpenGeometry&, const OpenValues&, int count, const Complex* points,
                    double* work, const Poses&);
Decide decide_portable, decide_avx2, decide_avx512;

}  // namespace gsp
