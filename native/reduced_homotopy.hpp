// Tracking of quadrics of which only the multiples of N move; plain data.
//
// An angle, a one-sided distance to a plane and the distance of two points are quadrics on the
// Study quadric. They are linear in e_i e_j, in h = f.f, and in the six coordinates of w = e ^ f.
// These are e0 f_i - e_i f0 and (e x f)_i; N T and N U are combinations of them. On e.f = 0, |w|^2
// = N h. So six of them are linear equations in the quantities q = (w, h), or q = w if none has h;
// each has its value times N. Solved for as many quantities as they determine (the pivots),
//
//     q_j = v_j N - form_j(e) - sum over l of slope_jl s_l,
//
// the others being M scalars s_l. In equations without a pivot there is no q_j, and slopes are zero
// or small. To be solved are those, e ^ w = 0 (three equations) and, with h, |w|^2 = N h, in e and the
// scalars. For six legs in general position these are 5 unknowns up to a factor instead of 8, for
// planar base and platform 6, for six planes 4.
#pragma once

#include <cstdint>

#include "tracker.hpp"

namespace gsp {

constexpr int kQuantities = 7, kMostScalars = 3, kForms = 10;

struct ReducedGeometry {
  int scalars;
  bool has_h;
  std::int32_t pivot[kEquations];   // the quantity of each solved equation
  std::int32_t free[kMostScalars];  // the quantity that each scalar is
  double form[kEquations][kForms];       // of e_i e_j, i <= j; rows of pivots first
  double slope[kEquations][kMostScalars];
};

struct ReducedOptions {
  double predictor_tolerance, contraction, radius_fraction, min_step;
  int max_steps;
};

// All coefficients along the way from a start (t = 0) to a target (1). If those of both are real but
// for their values, the imaginary parts are in the values, and forms and slopes are taken as real.
struct ReducedLine {
  bool real;
  double value[kEquations], value_change[kEquations];  // imaginary parts
  Complex form[kEquations][kForms], form_change[kEquations][kForms];
  Complex slope[kEquations][kMostScalars], slope_change[kEquations][kMostScalars];
};

// Paths from solved systems to others, `paths` to each; arrays over systems have complex values, the
// left sides of the equations solved for the pivots.
struct ReducedPaths {
  int paths;
  const Complex* start_values;  // (starts, 6)
  const Complex* starts;        // (starts, paths, coordinates)
  const std::int32_t* start;    // from which of them, (targets,)
  const std::int32_t* order;    // in which targets are reached, (targets,): starts together
  const Complex* values;        // (targets, 6)
  const ReducedLine* line;        // null: only values move; else there is one target, without values
};

struct ReducedEnds {
  Complex* point;        // (targets, paths, coordinates), |e| = 1
  Complex* study;        // (targets, paths, 8), of any norm
  std::uint8_t* status;  // (targets, paths)
  std::int32_t* steps;   // likewise
};

// Tracks all paths to the targets that are from `begin` to before `end` in order.
using TrackValues = void(const ReducedGeometry&, const ReducedOptions&, const ReducedPaths&, int begin, int end,
                       const ReducedEnds&);
TrackValues track_values_portable, track_values_avx2, track_values_avx512;

}  // namespace gsp
