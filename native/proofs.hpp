// Proofs in floating point that exactly one solution is near a point; plain data, no Python.
//
// The theorem, the bounds of all rounding errors and the names are those of
// gspcli.certification.poses.isolation: here the same is computed for as many points as there are lanes.
#pragma once

#include <cstdint>

#include "tracker.hpp"

namespace gsp {

constexpr int kMostQuadrics = 2 + 3 * kEquations;

// The equation A = 0 of the quadric `main`, or N A = B^2 + C^2 with the `squares` (-1: none).
struct ProofEquation {
  std::int32_t main, squares[2];
};

// Quadrics on C^8: N, e.f, and those of six equations.
struct ProofSystem {
  int quadrics;
  const double* hessian;  // (quadrics, 8, 8)
  const double* moduli;   // likewise: of the terms of each entry
  const ProofEquation* equation;
};

// The last one: numbers of a real pose are rounded correctly, those of others accurate (FinePoses).
enum Proved : std::uint8_t { kIsolated = 1, kReal = 2, kComplex = 4, kRounded = 8 };

}  // namespace gsp
