// Counts the roundings of isolation.hpp. For tests/unit/motion/following/test_roundings.py.
#include <cstdio>
#include <cstdlib>

#define GSP_PARTS 1
// An entry of a Hessian matrix errs by 2^-50 of its bound.
#define COUNTED_ENTRY 8
#include "isolation.hpp"

using namespace gsp;

int main() {
  static double hessian[kMostQuadrics][N][N];
  for (auto& quadric : hessian)
    for (auto& row : quadric)
      for (double& x : row) x = 0.1 + std::rand() / (4.0 * RAND_MAX);
  ProofEquation equation[kEquations];
  // Plain equations, products with one square, and with two.
  for (int r = 0; r < kEquations; ++r) {
    equation[r].main = 2 + r;
    equation[r].squares[0] = r % 3 ? 8 + r : -1;
    equation[r].squares[1] = r % 3 == 2 ? 14 + r : -1;
  }
  const ProofSystem system{kMostQuadrics, hessian[0][0], hessian[0][0], equation};
  C z[N];
  for (int i = 0; i < N; ++i) z[i] = {D(0.3 + 0.1 * i * i, 0), D(0.2 - 0.07 * i, 0)};
  const Mask above[kRows] = {};
  Linear at;
  linearize(system, z, above, at);
  int derivative = 0, product = 0, step = 0, bounds = 0;
  const C y{D(0.7, 0), D(0.6, 0)};
  for (auto& row : at.jacobian) {
    C s{D(1.0, 0), D(1.0, 0)};
    for (const C& x : row) derivative = std::max(derivative, count(x)), subtract_product(s, y, x);
    product = std::max(product, count(s));
  }
  // Values have 32 digits and are rounded to one double.
  C change[kRows];
  for (int i = 0; i < kRows; ++i) {
    at.value[i] = {D(0.1, 1), D(0.2, 1)};
    for (C& x : at.inverse[i]) x = y;
  }
  newton_step(at, change);
  for (const C& x : change) step = std::max(step, count(x));
  // Sums of nonnegative numbers: bounds of values, of derivatives, and of second derivatives.
  D m[N], value[kRows], whole[kRows][N], curvature[kRows];
  Quadrics<D> quadrics;
  for (D& x : m) x = D(1.3, 1);
  evaluate(system.quadrics, system.moduli, m, quadrics);
  combine(system, quadrics, 1.0, value, whole);
  curvatures(system, Units(z), m, curvature);
  for (int r = 0; r < kRows; ++r) {
    bounds = std::max({bounds, value[r].k, curvature[r].k});
    for (const D& x : whole[r]) bounds = std::max(bounds, x.k);
  }
  std::printf("%d %d %d %d\n", derivative, product, step, bounds);
  std::printf("%g %g %g\n", kRounding * 0x1p53, kStepRounding * 0x1p53, (kOutward - 1.0) * 0x1p53);
}
