// Proofs of single solutions of seven quadrics with 86 digits; plain data.
//
// The theorem is that of gspcli.certification.poses.isolation.
#pragma once

#include <cstdint>

#include "proofs.hpp"

namespace gsp {

constexpr int kDigitWords = 7;  // of a number with 288 binary places (fixed.hpp), the lowest first

// Seven quadrics: e . f and those of the constraints.
struct DigitSystem {
  int forms;                     // how many forms the quadrics are made of
  const double* table;           // (forms, 8, 8) their Hessian matrices, small integers
  const std::uint64_t* numbers;  // (7, forms, 7) the coefficients
  double error;                  // by which any of these may be off, outward
  // The points' own frames and unit: f becomes unit f + (base e - e platform) / 2.
  double unit;
  const double *base, *platform;  // (3)
};

struct DigitPoses {
  Complex* rotation;     // (count, 9)
  Complex* translation;  // (count, 3)
  Complex* quaternion;   // (count, 4), of any norm; one entry is 1
  Complex* norm;         // (count), of the quaternion: the square
  std::uint8_t* proved;  // bits of `Proved`
};

// Near which of the Study points (count, parts, 8), the sum of parts of any norm, there is exactly one
// solution, a simple one with N != 0. A point is proved only if its rotation and its translation
// are known to half a unit in the last place of doubles of their largest entry, before they are
// rounded to doubles.
void prove_with_digits(const DigitSystem& system, int count, int parts, const Complex* points,
                       const DigitPoses& out);

}  // namespace gsp
