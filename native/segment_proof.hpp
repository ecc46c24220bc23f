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
// Rounding: let no term of an expression in doubles go through more than m roundings. Then the
// expression differs from its exact value by at most m u / (1 - m u), u = 2^-53, times the same
// expression of the moduli of its terms (as in gspcli.certification.poses.isolation). The numbers z
// and d of a chord are exact by definition. Entries of Hessian matrices carry 4 roundings, a
// gradient 12, a value 21, c 9, N 5. A test runs these formulas with numbers that count: a coefficient
// of a plain equation has at most 28, a product 44, one of lines 68; with the factor tau^2 - 1/4
// split off and products with Y it is 77. So kPlain = 64 u and kOthers = 128 u bound it all. At tau
// the moduli of all coefficients add up to at most their expression at |z| + |d| / 2. Sums of
// nonnegative bounds are rounded outward at the end.
//
// Included by each build of branch_follower.cpp: all in an anonymous namespace, as in lanes.hpp.
#pragma once

#include <cmath>

#include "branch_follower.hpp"
#include "lanes.hpp"

namespace gsp {
namespace {

// The equations of a platform whose values move: values, derivatives, Newton's method.

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

// The equations along a chord as polynomials, with bounds of their derivatives and of all rounding.

constexpr double kPlain = 0x1p-47;
constexpr double kOthers = 0x1p-46;
constexpr double kOutward = 1.0 + 0x1p-40;
// Radius of the neighbourhood of the chord in which second derivatives are bounded.
constexpr double kReach = 0.125;

constexpr int kDegree = 6;  // of an equation along a chord

// A polynomial in tau.
struct Series {
  D x[kDegree + 1];
};

// s += factor a b, of the given degrees.
INLINE void add_product(Series& s, const D* a, int degree_a, const D* b, int degree_b,
                        double factor) {
  for (int i = 0; i <= degree_a; ++i)
    for (int j = 0; j <= degree_b; ++j) s.x[i + j] += factor * a[i] * b[j];
}

// The Jacobian matrix along a chord: its constant and linear part, and bounds of the rest.
struct Along {
  D constant[kRows][N], linear[kRows][N];
  D rest[kRows];       // of the part of order two and more, for |tau| <= 1/2
  Series value[kRows];
  D curvature[kRows];  // upper bound of the second derivatives within kReach
  D value_error[kRows], gradient_error[kRows];
};

// A vector-valued polynomial: of gradients.
struct Gradients {
  D x[kDegree][N];
};

INLINE void add_product(Gradients& s, const D* a, int degree_a, const D (*g)[N], int degree_g,
                        double factor, int size = N) {
  for (int i = 0; i <= degree_a; ++i)
    for (int j = 0; j <= degree_g; ++j) {
      const D f = factor * a[i];
      for (int k = 0; k < size; ++k) s.x[i + j][k] += f * g[j][k];
    }
}

// A quadric along z + tau d: gradients (2, 8) and the three coefficients of its value.
INLINE void along(const RealQuadric& q, const D* z, const D* d, D (*g)[N], D* x) {
  gradient(q, z, g[0]);
  gradient(q, d, g[1]);
  x[0] = 0.5 * dot(g[0], z);
  x[1] = dot(g[0], d);
  x[2] = 0.5 * dot(g[1], d);
}

// Coefficients of c(tau) between two values, and the largest deviation from them.
INLINE D moving(const MovingEquation& q, const D& from, const D& to, D* c) {
  const D change = to - from, middle = 0.5 * (from + to);
  switch (q.law) {
    case Law::kSquare:
      c[0] = middle * middle;
      c[1] = 2.0 * middle * change;
      c[2] = change * change;
      return D{};
    case Law::kLinear:
      c[0] = middle;
      c[1] = change;
      c[2] = D{};
      return D{};
    default:
      break;
  }
  // The parabola with the ends of the curve and about its second derivative; the third one is at
  // most one, so it deviates by at most (1/4 - tau^2) / 2 |change|^3 / 2.
  const D first = coefficient(q, from), last = coefficient(q, to), bent = coefficient(q, middle);
  const D half = -0.5 * bent * change * change;
  c[0] = 0.5 * (first + last) - 0.25 * half;
  c[1] = last - first;
  c[2] = half;
  const D size = absolute(change);
  return 0.0625 * size * size * size + 0x1p-50;
}

// Rounding of A^2 - c (N^2 - B^2). Where the lines are near each other A and c are small. The error
// of A^2 is then bounded by 2 A times the error of A, not by the square of the moduli of A.
INLINE void lines_errors(const MovingEquation& q, const D& square, const D& size, const D* a,
                         const D (*ga)[N], const D& c, D& value, D& gradient) {
  const double of_b = 0.5 * q.b.moduli;
  const D error_a = square * (0.5 * kPlain * q.a.moduli);
  const D error_g = size * (kPlain * q.a.moduli);
  const D size_a = absolute(a[0]) + 0.5 * absolute(a[1]) + 0.25 * absolute(a[2]);
  const D size_g = length(ga[0]) + 0.5 * length(ga[1]);
  const D gap = c * square * (kOthers * (1.0 + of_b * of_b));
  value = (2.0 * size_a + error_a) * error_a + kPlain * size_a * size_a + gap * square;
  gradient = 2.0 * ((size_a + error_a) * error_g + size_g * error_a + kPlain * size_a * size_g) +
             4.0 * gap * size;
}

// The six equations along the chord z + tau d.
void expand(const MovingSystem& system, const D* from, const D* to, const D* z, const D* d,
            Along& out) {
  // N along the chord.
  D gn[2][N] = {}, n[3];
  for (int i = 0; i < 4; ++i) {
    gn[0][i] = 2.0 * z[i];
    gn[1][i] = 2.0 * d[i];
  }
  n[0] = dot(z, z, 4);
  n[1] = 2.0 * dot(z, d, 4);
  n[2] = dot(d, d, 4);
  const D size_e = root(n[0]), size_de = root(n[2]);
  const D half = 0.5 * length(d), size = length(z) + half, square = size * size;
  const D reach = half + kReach;
  {
    Series& s = out.value[0];
    s = {};
    for (int i = 0; i < N; ++i) {
      out.constant[0][i] = z[(i + 4) % N];
      out.linear[0][i] = d[(i + 4) % N];
    }
    s.x[0] = 0.5 * dot(out.constant[0], z);
    s.x[1] = dot(out.constant[0], d);
    s.x[2] = 0.5 * dot(out.linear[0], d);
    out.rest[0] = D{};
    out.curvature[0] = splat(1.0);
    out.value_error[0] = kPlain * square;
    out.gradient_error[0] = kPlain * size;
  }
  for (int k = 0; k < kConstraints; ++k) {
    const MovingEquation& q = system.equation[k];
    Series& f = out.value[k + 1];
    D c[3], ga[2][N], a[3];
    const D deviation = moving(q, from[k], to[k], c);
    along(q.a, z, d, ga, a);
    f = {};
    D* constant = out.constant[k + 1];
    D* linear = out.linear[k + 1];
    if (q.form == Form::kPlain) {
      for (int i = 0; i < 3; ++i) f.x[i] = a[i];
      add_product(f, c, 2, n, 2, -1.0);
      for (int i = 0; i < N; ++i) {
        constant[i] = ga[0][i];
        linear[i] = ga[1][i];
      }
      for (int i = 0; i < 4; ++i) {
        constant[i] -= c[0] * gn[0][i];
        linear[i] -= c[0] * gn[1][i] + c[1] * gn[0][i];
      }
      out.rest[k + 1] = 0.5 * (absolute(c[1]) * size_de + absolute(c[2]) * size_e) +
                        0.25 * absolute(c[2]) * size_de + 2.0 * size * deviation;
      out.curvature[k + 1] = splat(q.spectral);
      const double moduli = q.a.moduli + 2.0 * q.largest;
      out.value_error[k + 1] = square * (0.5 * kPlain * moduli + deviation);
      out.gradient_error[k + 1] = size * (kPlain * moduli);
      continue;
    }
    D gb[2][N], b[3];
    along(q.b, z, d, gb, b);
    Gradients g{};
    // Sizes of the quadrics and of their gradients within reach of the chord.
    const D first_b = length(gb[0]) + q.b.spectral * reach;
    const D size_b = absolute(b[0]) + (length(gb[0]) + 0.5 * q.b.spectral * reach) * reach;
    const D first_n = 2.0 * (size_e + reach), size_n = 0.25 * first_n * first_n;
    if (q.form == Form::kProduct) {
      Series moved{};  // A - c N
      for (int i = 0; i < 3; ++i) moved.x[i] = a[i];
      add_product(moved, c, 2, n, 2, -1.0);
      add_product(f, n, 2, moved.x, 4, 1.0);
      add_product(f, b, 2, b, 2, -1.0);
      Gradients gm{};  // of A - c N
      for (int j = 0; j < 2; ++j)
        for (int i = 0; i < N; ++i) gm.x[j][i] = ga[j][i];
      add_product(gm, c, 2, gn, 1, -1.0, 4);
      add_product(g, n, 2, gm.x, 3, 1.0);
      add_product(g, moved.x, 4, gn, 1, 1.0, 4);
      add_product(g, b, 2, gb, 1, -2.0);
      // The form moves with c, too, by at most 1/2 |c1| + 1/4 |c2|.
      const D change = 0.5 * absolute(c[1]) + 0.25 * absolute(c[2]);
      const D first = length(gm.x[0]) + q.spectral * reach + change * first_n;
      const D size_a = absolute(moved.x[0]) + change * size_n + first * reach;
      out.curvature[k + 1] = 2.0 * size_a + size_n * q.spectral + 2.0 * first_n * first +
                             2.0 * (size_b * q.b.spectral + first_b * first_b);
    } else {
      Series gap{};  // N^2 - B^2
      add_product(gap, n, 2, n, 2, 1.0);
      add_product(gap, b, 2, b, 2, -1.0);
      add_product(f, a, 2, a, 2, 1.0);
      add_product(f, c, 2, gap.x, 4, -1.0);
      Gradients gg{};
      add_product(gg, n, 2, gn, 1, 2.0, 4);
      add_product(gg, b, 2, gb, 1, -2.0);
      add_product(g, a, 2, ga, 1, 2.0);
      add_product(g, c, 2, gg.x, 3, -1.0);
      const D first_a = length(ga[0]) + q.a.spectral * reach;
      const D size_a = absolute(a[0]) + (length(ga[0]) + 0.5 * q.a.spectral * reach) * reach;
      // Of c here, not of all that occur: it may be small, with A^2.
      const D largest = (absolute(c[0]) + 0.5 * absolute(c[1]) + 0.25 * absolute(c[2])) * kOutward;
      out.curvature[k + 1] =
          2.0 * (size_a * q.a.spectral + first_a * first_a) +
          largest * (4.0 * size_n + 2.0 * first_n * first_n +
                     2.0 * (size_b * q.b.spectral + first_b * first_b));
      lines_errors(q, square, size, a, ga, largest, out.value_error[k + 1],
                   out.gradient_error[k + 1]);
    }
    for (int i = 0; i < N; ++i) {
      constant[i] = g.x[0][i];
      linear[i] = g.x[1][i];
    }
    D rest{};
    double part = 0.25;
    for (int j = 2; j < kDegree; ++j, part *= 0.5) rest += part * length(g.x[j]);
    out.rest[k + 1] = rest;
    if (q.form == Form::kLines) continue;
    // Of the moduli, at norm one; a gradient of degree four is at most four times that.
    const double of_b = 0.5 * q.b.moduli, value = 0.5 * q.a.moduli + q.largest + of_b * of_b;
    out.value_error[k + 1] = square * square * (kOthers * value);
    out.gradient_error[k + 1] = square * size * (4.0 * kOthers * value);
  }
}

// The proof.

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
