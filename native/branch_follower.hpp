// Real branches of solutions followed while the values of constraints move; plain data, no Python.
//
// An equation is one of
//   plain      A - c N = 0
//   product    N (A - c N) - B^2 = 0
//   lines      A^2 - c (N^2 - B^2) = 0
// with real quadrics A and B on R^8, N = e.e, and a number c that depends on the value: its square,
// itself, or the cosine or sine of an angle. The values move linearly between rows.
#pragma once

#include <cstdint>

namespace gsp {

constexpr int kConstraints = 6;
constexpr int kCoordinates = 8;

enum class Form : std::int32_t { kPlain = 0, kProduct = 1, kLines = 2 };
enum class Law : std::int32_t { kSquare = 0, kLinear = 1, kCosine = 2, kSine = 3 };

struct RealQuadric {
  double hessian[kCoordinates][kCoordinates];
  double spectral;  // upper bound of the spectral norm of the Hessian matrix
  double moduli;    // upper bound of that of the matrix of the moduli of its terms
};

struct MovingEquation {
  Form form;
  Law law;
  double sign;      // of the cosine or sine
  double largest;   // upper bound of |c| for all values that occur
  double spectral;  // upper bound of the norm of the Hessian matrix of A - c N for all these c
  RealQuadric a, b;
};

struct MovingSystem {
  MovingEquation equation[kConstraints];
};

// How a branch ended.
enum class Stop : std::int32_t {
  kEnd = 0,       // after the last row
  kStep = 1,      // the step became too small: a fold, or another singular pose
  kStart = 2,     // no solution was found at the first row
};

struct FollowOptions {
  bool certify;
  int most_halvings;  // of the step between rows
};

// One branch: `rows` sets of six values, and the results.
struct Branch {
  const double* values;  // (rows, 6)
  int rows;
  double start[kCoordinates];
  double near;           // bound of the distance of the followed pose from the start; 0: the pose
                         // that Newton's method finds. Afterwards, a bound of the distance of the proved pose from `last`
  double* point;         // (rows, 8), of norm one
  Stop stop;
  int reached;           // the last row that was reached, -1 if none
  double fraction;       // how far beyond it the branch was followed, a part of the step to the next
  double last[kCoordinates];      // the point there
  double previous[kCoordinates];  // the one before, to see the direction
  std::int64_t segments, tries;
  double alone;          // distance from `last` within which there is no other pose
  double worst;          // largest q + sqrt(2 kappa beta) of a segment; proved below one
};

// Follows branches in lanes.
typedef void Follow(const MovingSystem&, const FollowOptions&, Branch*, int count);

Follow follow_portable;
#if defined(GSP_X86)
Follow follow_avx2, follow_avx512;
#endif

}  // namespace gsp
