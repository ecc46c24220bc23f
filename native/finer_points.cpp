// Built with GSP_PARTS = 4: lanes of quadruple-double numbers.
#include "fine_points.hpp"

#include "lanes.hpp"

namespace gsp {
namespace {

constexpr int kParts = 4;

D load(const double* from, int k) {
  D x;
  __builtin_memcpy(&x, from + k * W, sizeof x);
  return x;
}

// A number of 32 digits.
V load(const double* high, const double* low, int k) {
  const DoubleDouble x = exact_sum(load(high, k), load(low, k));
  return {x.hi, x.lo, D{}, D{}};
}

// One of a number of sums of four doubles.
V number(const double* from, int count, int k) {
  V x;
  for (int part = 0; part < kParts; ++part) put_part(x, part, from[part * count + k]);
  return x;
}

int monomial(int i, int j) { return i < 4 && j < 4 ? 4 * i - i * (i - 1) / 2 + j - i : 10 + 4 * i + j - 4; }

void monomials(const C* z, C* m) {
  for (int i = 0; i < 4; ++i)
    for (int j = i; j < N; ++j) m[monomial(i, j)] = z[i] * z[j];
  C square = z[4] * z[4];
  for (int i = 5; i < N; ++i) square = square + z[i] * z[i];
  m[kMonomials - 1] = square;
}

C quadric_at(const FinerGeometry& g, int q, const C* m) {
  const int count = g.quadrics * kMonomials;
  C sum{splat(0.0), splat(0.0)};
  for (int k = 0; k < kMonomials; ++k) {
    const int at = q * kMonomials + k;
    // The first part is zero only if all are.
    if (g.coefficient[at] == 0.0) continue;
    const V a = number(g.coefficient, count, at);
    sum = sum + a * m[k];
  }
  return sum;
}

void values(const FinerGeometry& g, const double* value, const double* distance, const FineNumbers& point,
            const LaneNumbers& out) {
  C z[N], m[kMonomials], quadric[kMostQuadrics];
  for (int i = 0; i < N; ++i)
    z[i] = {load(point.high.re, point.low.re, i), load(point.high.im, point.low.im, i)};
  monomials(z, m);
  for (int q = 0; q < g.quadrics; ++q) quadric[q] = quadric_at(g, q, m);
  const auto put_value = [&](int r, const C& x) {
    const D re = x.re.part[0] + x.re.part[1], im = x.im.part[0] + x.im.part[1];
    __builtin_memcpy(out.re + r * W, &re, sizeof re);
    __builtin_memcpy(out.im + r * W, &im, sizeof im);
  };
  put_value(0, quadric[1]);
  for (int r = 0; r < kEquations; ++r) {
    const ProofEquation& e = g.equation[r];
    const V by = number(g.weight, kEquations, r) * number(value, kEquations, r);
    C s = quadric[e.main] + by * quadric[0];
    if (e.squares[0] >= 0) s = quadric[0] * s;
    for (const int b : e.squares) {
      if (b < 0) continue;
      const C x = b == g.turned[r] ? number(distance, kEquations, r) * quadric[b] : quadric[b];
      s = s - x * x;
    }
    put_value(r + 1, s);
  }
}

}  // namespace

extern const FinerPoints GSP_FINER;
const FinerPoints GSP_FINER{values};

}  // namespace gsp
