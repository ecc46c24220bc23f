// Errors of fine_points.cpp with 32 digits. For tests/unit/motion/following/test_roundings.py.
#define GSP_PARTS 2
#define GSP_LANES 2
#define GSP_FINE fine_sampled
#include "fine_points.cpp"
#include "quad.hpp"

using namespace gsp;

int main() {
  std::mt19937_64 random(1);
  double worst = 0.0;
  constexpr int quadrics = 2 + 3 * kEquations;
  // Plain equations, products with one square, and with two.
  ProofEquation equation[kEquations];
  for (int r = 0; r < kEquations; ++r) {
    equation[r].main = 2 + r;
    equation[r].squares[0] = r % 3 ? 8 + r : -1;
    equation[r].squares[1] = r % 3 == 2 ? 14 + r : -1;
  }
  for (int round = 0; round < 2000; ++round) {
    std::vector<double> high(quadrics * kMonomials), low(high.size());
    std::uniform_real_distribution<double> part(-1, 1);
    for (double& x : high) x = part(random);
    for (std::size_t k = 0; k < high.size(); ++k) low[k] = 0x1p-54 * high[k] * part(random);
    Numbers point(N, W), monomials(kMonomials, W), value(kEquations + 1, W);
    // Real points, and the same times 1 + i: values are about zero if the coefficient of f . f makes up for the rest.
    for (int i = 0; i < N; ++i) {
      point.draw(random, i, 0);
      const Q x = point.at(i, 0).re;
      point.put(i, 0, x, 0), point.put(i, 1, x, x);
    }
    const auto quadric = [&](int q, int l) {
      Number sum, z[N], last;
      for (int i = 0; i < N; ++i) z[i] = point.at(i, l);
      const auto coefficient = [&](int k) {
        const Q a = Q(high[q * kMonomials + k]) + low[q * kMonomials + k];
        return Number{a, 0, modulus(a)};
      };
      for (int i = 0; i < 4; ++i)
        for (int j = i; j < N; ++j) sum = sum + coefficient(monomial(i, j)) * (z[i] * z[j]);
      for (int i = 4; i < N; ++i) last = last + z[i] * z[i];
      return sum + coefficient(kMonomials - 1) * last;
    };
    for (int r = 0; r < kEquations; ++r) {
      const ProofEquation& e = equation[r];
      const int place = e.main * kMonomials + kMonomials - 1;
      high[place] = low[place] = 0.0;
      Number wanted;
      for (const int b : e.squares)
        if (b >= 0) wanted = wanted + quadric(b, 0) * quadric(b, 0);
      Q last = 0;
      for (int i = 4; i < N; ++i) last += point.at(i, 0).re * point.at(i, 0).re;
      const Q c = ((e.squares[0] >= 0 ? wanted.re / quadric(0, 0).re : 0) - quadric(e.main, 0).re) / last;
      high[place] = double(c), low[place] = double(c - high[place]);
    }
    values(quadrics, equation, high.data(), low.data(), point.given(), monomials.given(), value.high());
    for (int l = 0; l < W; ++l)
      for (int r = 0; r < kEquations; ++r) {
        const ProofEquation& e = equation[r];
        Number exact = quadric(e.main, l);
        if (e.squares[0] >= 0) exact = quadric(0, l) * exact;
        for (const int b : e.squares)
          if (b >= 0) exact = exact - quadric(b, l) * quadric(b, l);
        worst = std::max(worst, error(value.at(r + 1, l), exact, exact.size));
      }
  }
  std::printf("%g\n", worst);
}
