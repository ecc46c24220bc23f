// The equations of a platform whose values move, in lanes: values, derivatives, Newton's method.
//
// Included by each build of branch_follower.cpp: all in an anonymous namespace, as in lanes.hpp.
#pragma once

#include <cmath>

#include "lanes.hpp"
#include "branch_follower.hpp"

namespace gsp {
namespace {

constexpr int kRows = kConstraints + 1;  // with the Study condition

INLINE D absolute(const D& x) { return x < 0.0 ? -x : x; }
INLINE D larger(const D& a, const D& b) { return a > b ? a : b; }
INLINE D smaller(const D& a, const D& b) { return a < b ? a : b; }

INLINE D dot(const D* a, const D* b, int n = N) {
  D s = a[0] * b[0];
  for (int i = 1; i < n; ++i) s += a[i] * b[i];
  return s;
}
INLINE D length(const D* a, int n = N) { return root(dot(a, a, n)); }

// The gradient of a quadric, H z.
INLINE void gradient(const RealQuadric& q, const D* z, D* g) {
  for (int i = 0; i < N; ++i) {
    D s = q.hessian[i][0] * z[0];
    for (int j = 1; j < N; ++j) s += q.hessian[i][j] * z[j];
    g[i] = s;
  }
}

// c for values of all lanes.
INLINE D coefficient(const MovingEquation& q, const D& value) {
  switch (q.law) {
    case Law::kSquare:
      return value * value;
    case Law::kLinear:
      return value;
    default:
      break;
  }
  D c;
  for (int l = 0; l < W; ++l)
    c[l] = q.sign * (q.law == Law::kCosine ? std::cos(value[l]) : std::sin(value[l]));
  return c;
}

// Values F and Jacobian matrix J of the Study condition and the six equations.
void linearize(const MovingSystem& system, const D* c, const D* z, D* F, D (*J)[N]) {
  for (int i = 0; i < N; ++i) J[0][i] = z[(i + 4) % N];
  F[0] = 0.5 * dot(J[0], z);
  const D n = dot(z, z, 4);
  for (int k = 0; k < kConstraints; ++k) {
    const MovingEquation& q = system.equation[k];
    D* row = J[k + 1];
    gradient(q.a, z, row);
    D a = 0.5 * dot(row, z);
    if (q.form == Form::kLines) {
      D g[N];
      gradient(q.b, z, g);
      const D b = 0.5 * dot(g, z);
      F[k + 1] = a * a - c[k] * (n * n - b * b);
      for (int i = 0; i < N; ++i) {
        row[i] = 2.0 * (a * row[i] + c[k] * b * g[i]);
        if (i < 4) row[i] -= 4.0 * c[k] * n * z[i];
      }
      continue;
    }
    a -= c[k] * n;
    for (int i = 0; i < 4; ++i) row[i] -= 2.0 * c[k] * z[i];
    if (q.form == Form::kPlain) {
      F[k + 1] = a;
      continue;
    }
    D g[N];
    gradient(q.b, z, g);
    const D b = 0.5 * dot(g, z);
    F[k + 1] = n * a - b * b;
    for (int i = 0; i < N; ++i) {
      row[i] = n * row[i] - 2.0 * b * g[i];
      if (i < 4) row[i] += 2.0 * a * z[i];
    }
  }
}

// M = L Q by modified Gram-Schmidt; the rows of M become those of Q.
template <int rows>
INLINE void factorize(D (*M)[N], D (*L)[rows], D* inverse) {
  for (int j = 0; j < rows; ++j) {
    D* q = M[j];
    const D scale = 1.0 / length(q);
    inverse[j] = scale;
    for (int k = 0; k < N; ++k) q[k] *= scale;
    for (int i = j + 1; i < rows; ++i) {
      const D s = dot(q, M[i]);
      for (int k = 0; k < N; ++k) M[i][k] -= s * q[k];
      L[i][j] = s;
    }
  }
}

// One step of Newton's method, orthogonal to the lines of equal points; returns its length.
D newton_step(const MovingSystem& system, const D* c, D* z) {
  D F[kRows], J[kRows][N], L[kRows][kRows], inverse[kRows];
  linearize(system, c, z, F, J);
  factorize<kRows>(J, L, inverse);
  for (int i = 0; i < kRows; ++i) {
    D s = F[i];
    for (int j = 0; j < i; ++j) s -= L[i][j] * F[j];
    F[i] = s * inverse[i];
  }
  D square{};
  for (int k = 0; k < N; ++k) {
    D s = J[0][k] * F[0];
    for (int j = 1; j < kRows; ++j) s += J[j][k] * F[j];
    z[k] -= s;
    square += s * s;
  }
  const D scale = 1.0 / length(z);
  for (int k = 0; k < N; ++k) z[k] *= scale;
  return root(square);
}

}  // namespace
}  // namespace gsp
