// Poses far away in local coordinates, for many sets of values of one geometry; plain data.
//
// A platform that is special up to a rounding of eps has poses eps^-2 lengths away, where N is
// eps^4. A value enters its equation as a multiple of N alone, so that these poses hardly depend on
// it. Let z be such a pose, and B the inverse of the Jacobian matrix of the equations F there. Let
// the values (squares of distances, heights, cosines) change by D. Then the point z + N B s, s in
// C^7, is a solution where
//
//     s + s^T Q s / 2 - D (1 + g s + s^T M s / 2) = 0,   Q = N B^T F'' B,  g = B^T N',  M = N B^T N'' B,
//
// seven equations whose numbers are all of order one or small, for any N. The proof is that of
// gspcli.certification.poses.isolation, with second derivatives that are constant.
//
// Some coordinates of solutions may be many powers of ten larger than others. Then s is P u with another vector u, and
// the equations are multiplied by P^-1 = L, so that each has the terms of one coordinate. The shift is L D.
//
// The distance of a point from a line is no quadric but G H = (c + D) N^2: G and H are heights over two complex planes
// through the line. Far away one of them, G, is large, and hardly changes. With its size g at z, and all forms over N
// there, the equation is P Q - (c + D) N^2 / g = 0 where P = G / g and Q = H. It has no row of other equations in it.
#pragma once

#include <cstdint>

#include "ends.hpp"

namespace gsp {

// Local coordinates; their monomials: 1, s_i, s_i s_j (i <= j, row by row).
constexpr int kLocal = kEquations + 1, kSquares = 28, kLocalMonomials = 1 + kLocal + kSquares;
// Forms in them: F / N, then N, N R by rows and N T, over N at z. Then e over the root of N at z, of which only the
// first 1 + kLocal coefficients are there. The last are the columns of L that D is multiplied by, row by row.
constexpr int kOfNorm = kLocal, kFarForms = kOfNorm + 13;
constexpr int kMixed = kFarForms * kLocalMonomials + 4 * (1 + kLocal);
constexpr int kFarNumbers = kMixed + kLocal * kEquations;
// What each product has besides, after all others: Q, and c / g. P is in its place among the forms.
constexpr int kConstant = kLocalMonomials, kOfProduct = kConstant + 1;
namespace {
constexpr int far_numbers(unsigned products) { return kFarNumbers + __builtin_popcount(products) * kOfProduct; }
}  // namespace

// The poses of one geometry with known values.
struct FarGeometry {
  int count;
  const Complex *number, *low;  // (count, far_numbers), and what double precision leaves of them
  // By how much the numbers err, besides 2^-104 of themselves, and F / N at z itself; (count).
  const double* error;
  // (count): whether the numbers are real; whether the conjugate of the pose has to be added.
  const std::uint8_t *real, *paired;
  // The last poses, to which paths lead: those at complex values further by the origin (6), with their local
  // coordinates there (bent, 7).
  int bent;
  const Complex *origin, *start;
  double scale, tolerance;  // see OpenGeometry
  unsigned products;        // bit r: equation r is a product
};

// Sets of values.
struct FarValues {
  int count;
  // (count, 3, 6): by how much the values are greater, what double precision leaves of that, and by how much
  // it errs.
  const double* shift;
  const double* unit;  // (count), see OpenValues
};

// Decides about all poses for all sets of values, in the order of the sets: those of the geometry, then the
// conjugates of those that are paired. Poses are complete if they are all proved and different. `work` has
// room for `kFarRoom` numbers.
using DecideFar = void(const FarGeometry&, const FarValues&, double* work, const Poses&);
DecideFar decide_far_portable, decide_far_avx2, decide_far_avx512;
// Follows the poses of a geometry from local coordinates (count, 7) for one shift (6) to those for another; says
// which were not lost. Of the geometry only the numbers are used.
using FollowFar = void(const FarGeometry&, const Complex* from, const Complex* to, double* work, Complex* local,
                       std::uint8_t* found);
FollowFar follow_far_portable, follow_far_avx2, follow_far_avx512;
// What one build has of both.
struct FarBuild {
  DecideFar* decide;
  FollowFar* follow;
};
constexpr int kFarRoom = 4 * (kFarNumbers + kEquations * kOfProduct) * 8;  // for 8 lanes

// The same with 32 digits, for a pose and values in each lane.
struct FineFarPoses {
  // The shift of each equation (7) for values further by a shift and what doubles leave of it (6 for each lane): they
  // err by less than 2^-97 times the sum of the moduli of their terms.
  void (*mix)(const FineNumbers& number, const double* shift, const double* shift_low, const FineNumbers& mixed);
  // The equations at local coordinates (7), shifted: they err by less than 2^-96 times the sum of the moduli of
  // their terms, products by twice that. `second` says for each where Q of a product is, zero for others.
  void (*values)(const FineNumbers& number, const int* second, const FineNumbers& local, const FineNumbers& mixed,
                 const LaneNumbers& value);
  // The poses at local coordinates less a change (7), which are known up to an error each then, as
  // `FinePoints.poses`, with a unit for each. The numbers err by `doubt`.
  void (*poses)(const FineNumbers& number, const FineNumbers& local, const LaneNumbers& change,
                const double* error, const double* doubt, const double* real, const double* unit, const FinePoses&);
};
extern const FineFarPoses fine_far_portable, fine_far_avx2, fine_far_avx512;

}  // namespace gsp
