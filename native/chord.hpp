// The equations along a chord as polynomials, with bounds of their derivatives and of all rounding.
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
// Included by each build of branch_follower.cpp.
#pragma once

#include "moving_equations.hpp"

namespace gsp {
namespace {

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

}  // namespace
}  // namespace gsp
