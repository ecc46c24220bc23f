// Matrices of six rows.
#pragma once

#include <cmath>

namespace gsp::live {

using Matrix = double[6][6];

// Turns rows of `a` until they are orthogonal, and those of `u` alike: of a = U S V^T, S V^T is left and,
// if `u` was the identity, U^T (M. R. Hestenes, Inversion of matrices by biorthogonalization and related
// results, 1958).
inline void decompose(Matrix& a, Matrix& u) {
  constexpr int kSweeps = 30;
  constexpr double kOrthogonal = 1e-16;
  bool turned = true;
  for (int sweep = 0; turned && sweep < kSweeps; ++sweep) {
    turned = false;
    for (int i = 0; i < 6; ++i)
      for (int j = i + 1; j < 6; ++j) {
        double p = 0.0, x = 0.0, y = 0.0;
        for (int k = 0; k < 6; ++k) p += a[i][k] * a[j][k], x += a[i][k] * a[i][k], y += a[j][k] * a[j][k];
        if (!(std::abs(p) > kOrthogonal * std::sqrt(x * y))) continue;
        turned = true;
        const double zeta = (y - x) / (2.0 * p);
        const double t = std::copysign(1.0, zeta) / (std::abs(zeta) + std::sqrt(1.0 + zeta * zeta));
        const double c = 1.0 / std::sqrt(1.0 + t * t), s = c * t;
        for (Matrix* m : {&a, &u})
          for (int k = 0; k < 6; ++k) {
            const double first = (*m)[i][k], second = (*m)[j][k];
            (*m)[i][k] = c * first - s * second, (*m)[j][k] = s * first + c * second;
          }
      }
  }
}

inline double length(const double (&row)[6]) {
  double sum = 0.0;
  for (const double x : row) sum += x * x;
  return std::sqrt(sum);
}

}  // namespace gsp::live
