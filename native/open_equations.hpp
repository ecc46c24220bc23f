// The equations of a geometry with its values left open, from numbers of 32 digits; plain data.
//
// The forms are those of gspcli.geometry.study, what is made of them that of
// gspcli.certification.equations.ball_system: here in doubled precision, with a bound of what is lost.
#pragma once

#include <cstdint>

#include "proofs.hpp"

namespace gsp {

constexpr int kStudyForms = 27;

// A number within 2^-96 times its size of high + low; not larger than its size.
struct Doubled {
  double high = 0.0, low = 0.0, size = 0.0;
};

// What a constraint is a distance or an angle of; a height is a distance from a plane.
enum class Relation : std::int32_t {
  kPoints, kBaseHeight, kPlatformHeight, kBaseLine, kPlatformLine, kLines, kAngle, kMeetingLines
};

struct Primitives {
  Relation relation;
  Doubled a[3], b[3], u[3], v[3];  // points and directions, of the platform (a, u) and the base
};

// See OpenGeometry; room for kMostQuadrics quadrics.
struct OpenEquations {
  int quadrics;
  double *hessian, *low, *moduli;      // (kMostQuadrics, 8, 8)
  double *weight, *weight_bound, *norm_bound, *weight_low;  // (6)
  std::int32_t* table;                 // (6, 3), -1: none
  std::int32_t* turned;                // (6), -1: none
};

// `tables` are the Hessian matrices of the forms, (27, 8, 8), integers; `tiny` is added to bounds, for
// what becomes a subnormal number.
void open_equations(const Primitives* constraints, const double* tables, double tiny,
                    OpenEquations& out);

}  // namespace gsp
