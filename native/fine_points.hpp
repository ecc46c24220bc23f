// Points that are known to 32 digits: the equations there, and their poses correctly rounded; plain
// data.
#pragma once

#include <cstdint>

#include "proofs.hpp"

namespace gsp {

// What quadrics in Study points are combinations of: e_i e_j (i <= j, row by row), e_i f_j, f . f.
constexpr int kMonomials = 27;

// The equations of a geometry with distances and cosines of zero, and how its values enter them.
struct FineGeometry {
  int quadrics;
  const double *hessian, *hessian_low;  // (quadrics, 8, 8), and what double precision leaves of it
  const double *weight, *weight_low;    // (6)
  const std::int32_t* turned;           // (6), see OpenGeometry
  const ProofEquation* equation;
};

struct FineValues {
  const double *value, *value_low, *distance, *distance_low;  // (6) each
};

// Complex numbers of as many points as a build has lanes: number k of lane l stands at k lanes + l.
struct LaneNumbers {
  double *re, *im;
};
// The same with what double precision leaves of them.
struct FineNumbers {
  LaneNumbers high, low;
};

// Poses of as many points as there are lanes.
struct FinePoses {
  LaneNumbers entry;   // (16): R by rows, T, the quaternion with e.e = 1
  double* deviation;   // bounds of the errors of entries of R and T
  double* rounded;     // 1 where every number of a real pose is proved to be rounded correctly, or those of a complex
                       // one are within 2^-53 of the largest; else 0
};

struct FinePoints {
  // The coefficients (quadrics, 27) of one set of values, and what double precision leaves of them.
  void (*coefficients)(const FineGeometry&, const FineValues&, double* high, double* low);
  // The monomials (27) and the seven equations (7) at points (8). The equations err by less than 2^-94
  // times the sum of the moduli of their terms: coefficients by 2^-96, products and sums by 2^-99.
  void (*values)(int quadrics, const ProofEquation*, const double* high, const double* low, const FineNumbers& point,
                 const FineNumbers& monomials, const LaneNumbers& value);
  // The poses of these points less a change (8), that are known up to an error each then, that of f in units; real (1)
  // or not (0). Numbers below 2^-12 units are rounded to multiples of 2^-64 units, others to the
  // nearest double. The unit is a power of two above all numbers of R, of T (but not below the one
  // given), or of the quaternion.
  void (*poses)(const FineNumbers& point, const FineNumbers& monomials, const LaneNumbers& change,
                const double* error, const double* f_unit, const double* real, const double* unit, const FinePoses&);
};
extern const FinePoints fine_portable, fine_avx2, fine_avx512;

}  // namespace gsp
