// Built with GSP_PARTS = 2: lanes of double-double numbers.
#include "residuals.hpp"

#include "lanes.hpp"
#include "pair.hpp"

namespace gsp {
namespace {

// The Hessian matrices for one set of values.
void insert(const FineGeometry& g, const FineValues& given, double* hessian, double* low) {
  const int size = g.quadrics * N * N;
  for (int i = 0; i < size; ++i) hessian[i] = g.hessian[i], low[i] = g.hessian_low[i];
  const auto put_pair = [&](int i, const Pair& x) { hessian[i] = x.hi, low[i] = x.lo; };
  for (int r = 0; r < kEquations; ++r) {
    const Pair shift = product({g.weight[r], g.weight_low[r]}, {given.value[r], given.value_low[r]});
    for (int i = 0; i < 4; ++i) {
      const int at = g.equation[r].main * N * N + i * (N + 1);
      put_pair(at, sum({hessian[at], low[at]}, {2.0 * shift.hi, 2.0 * shift.lo}));
    }
    if (g.turned[r] < 0) continue;
    for (int i = g.turned[r] * N * N; i < (g.turned[r] + 1) * N * N; ++i)
      put_pair(i, product({hessian[i], low[i]}, {given.distance[r], given.distance_low[r]}));
  }
}

// The value of a quadric.
C evaluate(const double* hessian, const double* low, const C* z) {
  C value{};
  for (int i = 0; i < N; ++i) {
    C s{};
    for (int j = 0; j < N; ++j) {
      const int k = N * i + j;
      if (hessian[k] == 0.0 && low[k] == 0.0) continue;
      const V coefficient{D{} + hessian[k], D{} + low[k]};
      s.re += coefficient * z[j].re;
      s.im += coefficient * z[j].im;
    }
    add_product(value, z[i], s);
  }
  return {0.5 * value.re, 0.5 * value.im};
}

void residuals(const FineGeometry& g, const FineValues& given, int count, const Complex* point,
               const Complex* low, double* work, Complex* out) {
  double *const hessian = work, *const rest = work + g.quadrics * N * N;
  insert(g, given, hessian, rest);
  C z[N], quadric[kMostQuadrics], value[kEquations + 1];
  for (int l = 0; l < W; ++l) {
    const int p = l < count ? l : count - 1;
    for (int i = 0; i < N; ++i) {
      put(z[i], l, point[N * p + i]);
      z[i].re.lo[l] = low[N * p + i].re;
      z[i].im.lo[l] = low[N * p + i].im;
    }
  }
  for (int q = 0; q < g.quadrics; ++q)
    quadric[q] = evaluate(hessian + q * N * N, rest + q * N * N, z);
  value[0] = quadric[1];
  for (int r = 0; r < kEquations; ++r) {
    const ProofEquation& e = g.equation[r];
    if (e.squares[0] < 0) {
      value[r + 1] = quadric[e.main];
      continue;
    }
    C s = quadric[0] * quadric[e.main];
    for (const int b : e.squares) {
      if (b < 0) break;
      subtract_product(s, quadric[b], quadric[b]);
    }
    value[r + 1] = s;
  }
  for (int l = 0; l < count; ++l)
    for (int r = 0; r < kEquations + 1; ++r) out[l * (kEquations + 1) + r] = lane(value[r], l);
}

}  // namespace

void GSP_RESIDUALS(const FineGeometry& geometry, const FineValues& values, int count,
                   const Complex* point, const Complex* low, double* work, Complex* value) {
  residuals(geometry, values, count, point, low, work, value);
}

}  // namespace gsp
