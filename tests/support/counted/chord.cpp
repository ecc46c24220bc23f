// Counts the roundings of segment_proof.hpp, and measures how far values of an angle are
// from the parabola along a chord. For tests/unit/motion/following/test_roundings.py.
#include <cstdio>

#include "segment_proof.hpp"

using namespace gsp;

namespace {

int most(int a, const D& b) { return std::max(a, b.k); }

void count() {
  MovingSystem system{};
  for (int k = 0; k < kConstraints; ++k) {
    MovingEquation& q = system.equation[k];
    q.form = static_cast<Form>(k % 3);
    q.law = k < 3 ? Law::kSquare : Law::kCosine;
    q.sign = 1.0;
    for (RealQuadric* of : {&q.a, &q.b})
      for (auto& row : of->hessian)
        for (double& x : row) x = 0.7;
  }
  D z[N], d[N], from[kConstraints], to[kConstraints];
  // The numbers of a chord are exact; values are products of a number, a unit and a scale.
  for (int i = 0; i < N; ++i) z[i] = D(0.3 + i, 0), d[i] = D(0.1 + i, 0);
  for (int k = 0; k < kConstraints; ++k) from[k] = D(0.4, 3), to[k] = D(0.5, 3);
  Along out{};
  expand(system, from, to, z, d, out);
  int value[3] = {}, part[3] = {}, gradient[3] = {};
  for (int k = 0; k < kConstraints; ++k) {
    const D* f = out.value[k + 1].x;
    for (int j = 0; j <= kDegree; ++j) value[k % 3] = most(value[k % 3], f[j]);
    // F = r0 + r1 tau + (tau^2 - 1/4) G, and products of the parts with seven rows of Y.
    const D g4 = f[6], g3 = f[5], g2 = f[4] + 0.25 * g4, g1 = f[3] + 0.25 * g3, g0 = f[2] + 0.25 * g2;
    const D r1 = f[1] + 0.25 * g1, r0 = f[0] + 0.25 * g0, y(0.7, 0);
    for (const D& x : {r0, r1, g0, g1, g2, g3, g4}) {
      D s{};
      for (int c = 0; c < kRows; ++c) s += y * x;
      part[k % 3] = most(part[k % 3], s);
    }
    for (int i = 0; i < N; ++i)
      for (const D& x : {out.constant[k + 1][i], out.linear[k + 1][i]}) {
        D s{};
        for (int c = 0; c < kRows; ++c) s += y * x;
        gradient[k % 3] = most(gradient[k % 3], s);
      }
  }
  for (int k = 0; k < 3; ++k) std::printf("%d %d %d %d\n", k, value[k], part[k], gradient[k]);
  std::printf("constants %g %g\n", kPlain * 0x1p53, kOthers * 0x1p53);
}

void angles() {
  MovingEquation q{};
  q.law = Law::kCosine;
  q.sign = 1.0;
  double worst = 0.0;
  for (int i = 0; i < 60; ++i)
    for (int j = 0; j < 20; ++j) {
      const double a = 0.1 * i, change = 0.05 * (j + 1);
      D c[3];
      const double room = moving(q, D(a), D(a + change), c).v;
      for (int m = -50; m <= 50; ++m) {
        const double tau = m / 100.0, exact = std::cos(a + (tau + 0.5) * change);
        const double off = std::fabs(exact - (c[0].v + c[1].v * tau + c[2].v * tau * tau));
        worst = std::max(worst, off / room);
      }
    }
  std::printf("angles %g\n", worst);
}

}  // namespace

int main() {
  count();
  angles();
}
