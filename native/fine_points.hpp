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
  double* rounded;     // 1 where every number is proved to be rounded correctly, else 0
};

// Values in lanes, number r of lane l at r lanes + l, in two parts: `re` and `im`.
struct FineLaneValues {
  const double *weight, *weight_low;
  const std::int32_t* turned;
  LaneNumbers value, distance;
};

struct FinePoints {
  // The coefficients (quadrics, 27) of one set of values, and what double precision leaves of them.
  void (*coefficients)(const FineGeometry&, const FineValues&, double* high, double* low);
  // The monomials (27) and the seven equations (7) at points (8). The equations err by less than 2^-94
  // times the sum of the moduli of their terms: coefficients by 2^-96, products and sums by 2^-99.
  // Values that are not among the coefficients are given, else null.
  void (*values)(int quadrics, const ProofEquation*, const double* high, const double* low, const FineLaneValues*,
                 const FineNumbers& point, const FineNumbers& monomials, const LaneNumbers& value);
  // The poses of these points less a change (8), that are known up to an error each then, that of f in units; real (1)
  // or not (0). Numbers below 2^-12 units are rounded to multiples of 2^-64 units, others to the
  // nearest double. The unit is a power of two above all numbers of R, of T (but not below the one
  // given), or of the quaternion.
  void (*poses)(const FineNumbers& point, const FineNumbers& monomials, const LaneNumbers& change,
                const double* error, const double* f_unit, const double* real, const double* unit, const FinePoses&);
  // The poses of points (8) of which N, N R by rows and N T are known (13), that err by less than 2^-190
  // times the sum of the moduli of their terms. The errors of f are in units.
  void (*poses_of)(const FineNumbers& point, const FineNumbers& motion, const double* error, const double* f_unit,
                   const double* real, double unit, const FinePoses&);
};
extern const FinePoints fine_portable, fine_avx2, fine_avx512;

// The numbers of a geometry with 64 digits, for poses at which the equations are nearly dependent: each is
// the sum of four doubles.
struct FinerGeometry {
  int quadrics;
  const double *coefficient, *weight;  // (4, quadrics, 27) with distances and cosines of zero, (4, 6)
  const std::int32_t* turned;          // (6), see OpenGeometry
  const ProofEquation* equation;
};

// Numbers of 64 digits of as many points as a build has lanes: each is the sum of four doubles.
struct FinerNumbers {
  LaneNumbers part[4];
};

// Equations of quadrics with 64 digits, their values among the coefficients (4, quadrics, 27).
struct FinerQuadrics {
  int quadrics;
  const double* coefficient;
  const ProofEquation* equation;
};

// Frames of points: f becomes unit f + (base e - e platform) / 2.
struct OwnFrames {
  double unit, base[3], platform[3];
};

struct FinerPoints {
  // The seven equations at points of 32 digits, for values and distances (4, 6) in each lane. Their errors are
  // below 2^-150 times the sum of the moduli of their terms. For only a part of at most 2^-150 of
  // that sum is computed with rounding.
  void (*values)(const FinerGeometry&, const double* value, const double* distance, const FineNumbers& point,
                 const LaneNumbers& out);
  // Moves points to the frames of the equations; the largest coordinate of e, whose index is returned, is 1.
  void (*place)(const OwnFrames&, const FinerNumbers& point, double* patch);
  // The seven equations and their derivatives (7, 8) at points of 64 digits. They err by less than 2^-190, and
  // 2^-95, times the sum of the moduli of their terms.
  void (*linearize)(const FinerQuadrics&, const FinerNumbers& point, const FineNumbers& values,
                    const FineNumbers& derivatives);
  // Subtracts a change (8) from points; the results err by less than 2^-190 times the moduli of both.
  void (*move)(const FinerNumbers& point, const FineNumbers& change);
  // N, N R by rows and N T (13), as FinePoints::poses_of needs them.
  void (*motion)(const FinerNumbers& point, const FineNumbers& out);
};
extern const FinerPoints finer_portable, finer_avx2, finer_avx512;

}  // namespace gsp
