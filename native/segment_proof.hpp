// Proves that a segment belongs to one branch, and that no other branch is near.
//
// On a segment, tau from -1/2 to 1/2, let z(tau) be the chord between two points of norm about one
// on the patch p.z = 1. Let F(z, tau) be the Study condition, the six equations and p.z - 1, and Y
// an approximate inverse of the Jacobian matrix in the middle. Suppose that for all tau
//
//   |Y F(z(tau), tau)| <= beta,   |1 - Y F'(z(tau), tau)| <= q,
//   |Y (F'(x, tau) - F'(y, tau))| <= kappa |x - y| for x, y within kReach of the chord.
//
// Then z - Y F(z, tau) is a contraction on the ball about z(tau) of any radius below u =
// min(kReach, (1 - q) / kappa). If (1 - q)^2 > 2 kappa beta, let r be the smaller root of kappa r^2
// / 2 - (1 - q) r + beta. Then the ball of radius r is mapped into itself. So for each tau exactly
// one zero is within u of the chord; it is within r, and simple (Newton-Kantorovich; L. Rall,
// Computational Solution of Nonlinear Operator Equations, 1969, section 22). These zeros are one
// smooth branch, and no other branch comes within u - r of it.
//
// Two segments meet in the same zero if the ball that the first proves about its end lies within u
// of the second. The ends are nearly exact, so the same bounds hold there with a much smaller beta.
//
// Included by each build of branch_follower.cpp.
#pragma once

#include "chord.hpp"

namespace gsp {
namespace {

// Chords longer than this are not tried: points have norm one.
constexpr double kLongest = 0.5;
// Upper bound of the norm of the middle of such a chord.
constexpr double kNorm = 1.07;

constexpr int kAll = kRows + 1;  // with the patch

struct Proof {
  D measure;     // q + sqrt(2 kappa beta); below one: proved
  D end;         // a bound of the distances of the zeros at both ends from the points
  D uniqueness;  // u
};

// Tries to prove the segment between two points; moves both onto the patch.
Proof prove(const MovingSystem& system, const D* from, const D* to, D* z0, D* z1) {
  D p[N], z[N], d[N];
  for (int i = 0; i < N; ++i) p[i] = z0[i] + z1[i];
  {
    const D scale = 1.0 / length(p);
    for (int i = 0; i < N; ++i) p[i] *= scale;
    const D s0 = 1.0 / dot(p, z0), s1 = 1.0 / dot(p, z1);
    for (int i = 0; i < N; ++i) {
      const D x = s0 * z0[i], y = s1 * z1[i];
      z[i] = 0.5 * (x + y);
      d[i] = y - x;
    }
  }
  Along chord;
  expand(system, from, to, z, d, chord);

  // Y from the factorization of the Jacobian matrix in the middle, with the patch.
  D Q[kAll][N], L[kAll][kAll], inverse[kAll];
  for (int i = 0; i < kRows; ++i)
    for (int k = 0; k < N; ++k) Q[i][k] = chord.constant[i][k];
  for (int k = 0; k < N; ++k) Q[kRows][k] = p[k];
  factorize<kAll>(Q, L, inverse);
  D X[kAll][kAll];  // L^-1
  for (int c = 0; c < kAll; ++c) {
    X[c][c] = inverse[c];
    for (int i = c + 1; i < kAll; ++i) {
      D s{};
      for (int j = c; j < i; ++j) s -= L[i][j] * X[j][c];
      X[i][c] = s * inverse[i];
    }
  }
  D Y[N][kAll], norm[kAll];
  for (int c = 0; c < kAll; ++c) {
    D square{};
    for (int k = 0; k < N; ++k) {
      D s = Q[c][k] * X[c][c];
      for (int j = c + 1; j < kAll; ++j) s += Q[j][k] * X[j][c];
      Y[k][c] = s;
      square += s * s;
    }
    norm[c] = root(square);
  }

  // |1 - Y J| in the middle, in the Frobenius norm.
  D defect{};
  for (int k = 0; k < N; ++k)
    for (int i = 0; i < N; ++i) {
      D s = Y[k][kRows] * p[i];
      for (int c = 0; c < kRows; ++c) s += Y[k][c] * chord.constant[c][i];
      if (i == k) s -= 1.0;
      defect += s * s;
    }
  // |Y J1|: at most the Frobenius norm, and the root of row norm times column norm.
  D frobenius{}, rows{}, column[N] = {};
  for (int k = 0; k < N; ++k) {
    D row{};
    for (int i = 0; i < N; ++i) {
      D s{};
      for (int c = 0; c < kRows; ++c) s += Y[k][c] * chord.linear[c][i];
      frobenius += s * s;
      const D size = absolute(s);
      row += size;
      column[i] += size;
    }
    rows = larger(rows, row);
  }
  D columns = column[0];
  for (int i = 1; i < N; ++i) columns = larger(columns, column[i]);
  D q = root(defect) + 0.5 * root(smaller(frobenius, rows * columns));

  // F = r0 + r1 tau + (tau^2 - 1/4) G; the maxima of (1/4 - tau^2) |tau|^k weigh the parts of G.
  D g0[kRows], g1[kRows], end = norm[kRows] * (kPlain * kNorm * kNorm), bent{}, kappa{};
  for (int c = 0; c < kRows; ++c) {
    const D* f = chord.value[c].x;
    const D g4 = f[6], g3 = f[5], g2 = f[4] + 0.25 * g4;
    g1[c] = f[3] + 0.25 * g3;
    g0[c] = f[2] + 0.25 * g2;
    const D r1 = f[1] + 0.25 * g1[c], r0 = f[0] + 0.25 * g0[c];
    end += norm[c] * (absolute(r0) + 0.5 * absolute(r1) + chord.value_error[c]);
    bent += norm[c] * (0.015625 * absolute(g2) + 0.00582 * absolute(g3) + 0.00232 * absolute(g4));
    kappa += norm[c] * chord.curvature[c];
    q += norm[c] * (chord.rest[c] + chord.gradient_error[c]);
  }
  q += kPlain * kNorm * norm[kRows];
  D square0{}, square1{};
  for (int k = 0; k < N; ++k) {
    D s0{}, s1{};
    for (int c = 0; c < kRows; ++c) {
      s0 += Y[k][c] * g0[c];
      s1 += Y[k][c] * g1[c];
    }
    square0 += s0 * s0;
    square1 += s1 * s1;
  }
  D beta = end + bent + 0.25 * root(square0) + 0.04812 * root(square1);
  q *= kOutward;
  beta *= kOutward;
  kappa *= kOutward;
  end *= kOutward;

  Proof proof;
  const D left = 1.0 - q;
  proof.measure = (q + root(2.0 * kappa * beta)) * kOutward;
  proof.uniqueness = smaller(left / kappa, splat(kReach)) * (1.0 - 0x1p-40);
  proof.end = 2.0 * end / left * kOutward;
  // The tube stays within reach, its chord is short, and N does not vanish in it.
  const D r = 2.0 * beta / left * kOutward;
  const D size = length(d), patch = dot(p, z);
  const Mask good = (proof.measure < 1.0) & (r < kReach) & (size < kLongest) &
                    (length(z) < kNorm) & (patch > 0.9) &
                    (length(z, 4) - 0.5 * length(d, 4) > r * kOutward);
  proof.measure = good ? proof.measure : larger(proof.measure, splat(2.0));
  return proof;
}

}  // namespace
}  // namespace gsp
