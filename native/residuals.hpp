// The values of the equations of many_values.py with 32 digits; plain data.
#pragma once

#include <cstdint>

#include "proofs.hpp"

namespace gsp {

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

// The seven equations at `count` points (count, 8), at most as many as there are lanes; `work` has room for
// 2 quadrics * 64 numbers. The values (count, 7) err by less than 2^-90 times the sum of the moduli of
// their terms.
using Residuals = void(const FineGeometry&, const FineValues&, int count, const Complex* point,
                       const Complex* low, double* work, Complex* value);
Residuals residuals_portable_extended, residuals_avx2_extended, residuals_avx512_extended;

}  // namespace gsp
