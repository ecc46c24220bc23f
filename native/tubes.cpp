// Follows real branches of solutions, and proves each segment to be one branch and the only one near.
//
// On a segment, tau from -1/2 to 1/2, let z(tau) be the chord between two points of norm about one
// on the patch p.z = 1, F(z, tau) the Study condition, the six equations and p.z - 1, and Y an
// approximate inverse of the Jacobian matrix in the middle. Suppose that for all tau
//
//   |Y F(z(tau), tau)| <= beta,   |1 - Y F'(z(tau), tau)| <= q,
//   |Y (F'(x, tau) - F'(y, tau))| <= kappa |x - y| for x, y within kReach of the chord.
//
// Then z - Y F(z, tau) contracts the ball about z(tau) of any radius below u = min(kReach,
// (1 - q) / kappa), and if (1 - q)^2 > 2 kappa beta it maps the ball of the smaller root r of
// kappa r^2 / 2 - (1 - q) r + beta into itself: for each tau there is exactly one zero within u,
// within r of the chord, and simple (Newton-Kantorovich; L. Rall, Computational Solution of
// Nonlinear Operator Equations, 1969, section 22). So these zeros are one smooth branch, and no
// other one comes within u - r of it.
//
// Two segments meet in the same zero if what the first proves about its end lies within u of the
// second; the ends are nearly exact, so that the same bounds with a much smaller beta hold there.
//
// Rounding: an expression in doubles differs from its exact value by at most m u / (1 - m u), u = 2^-53,
// times the same expression of the moduli of its terms, if no term goes through more than m roundings
// (as in gspcli.certification.floating). The numbers z and d of a chord are exact by definition.
// Entries of Hessian matrices carry 4 roundings, a gradient 12, a value 21, c 9, N 5. A coefficient
// of a plain equation has at most 27, one of the other equations 60 (c times N^2 - B^2). Splitting off
// the factor tau^2 - 1/4 adds 6, products with Y 12. So kPlain = 64 u and kOthers = 128 u bound it
// all. At tau the moduli of all coefficients add up to at most their expression at |z| + |d| / 2. Sums
// of nonnegative bounds are rounded outward at the end.
#include "tubes.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "lanes.hpp"

namespace gsp {
namespace {

constexpr double kPlain = 0x1p-47;
constexpr double kOthers = 0x1p-46;
constexpr double kOutward = 1.0 + 0x1p-40;
// Radius of the neighbourhood of the chord in which second derivatives are bounded.
constexpr double kReach = 0.125;
// Chords longer than this are not tried: points have norm one.
constexpr double kLongest = 0.5;
// Not below the norm of the middle of such a chord.
constexpr double kNorm = 1.07;
constexpr double kProved = 0.98;
// Newton's method: a correction below this leaves an error of its square.
constexpr double kConverged = 1e-8;
constexpr double kDiverged = 0.5;
constexpr int kNewtonSteps = 6;
// Segments that are followed before they are proved.
constexpr int kBlock = 8;
// A step is doubled when all segments of a block have a measure below this,
constexpr double kEasy = 0.35;
// or after so many blocks without failure: rounding may keep the measure up whatever the step.
constexpr int kPatience = 4;

constexpr int kRows = kConstraints + 1;  // with the Study condition
constexpr int kAll = kRows + 1;          // with the patch
constexpr int kDegree = 6;               // of an equation along a chord

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
  D curvature[kRows];  // not below the second derivatives within kReach
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
      out.curvature[k + 1] =
          2.0 * (size_a * q.a.spectral + first_a * first_a) +
          q.largest * (4.0 * size_n + 2.0 * first_n * first_n +
                       2.0 * (size_b * q.b.spectral + first_b * first_b));
    }
    for (int i = 0; i < N; ++i) {
      constant[i] = g.x[0][i];
      linear[i] = g.x[1][i];
    }
    D rest{};
    double part = 0.25;
    for (int j = 2; j < kDegree; ++j, part *= 0.5) rest += part * length(g.x[j]);
    out.rest[k + 1] = rest;
    // Of the moduli, at norm one; a gradient of degree four is at most four times that.
    const double of_a = 0.5 * q.a.moduli, of_b = 0.5 * q.b.moduli;
    const double value = q.form == Form::kProduct ? of_a + q.largest + of_b * of_b
                                                  : of_a * of_a + q.largest * (1.0 + of_b * of_b);
    out.value_error[k + 1] = square * square * (kOthers * value);
    out.gradient_error[k + 1] = square * size * (4.0 * kOthers * value);
  }
}

struct Proof {
  D measure;     // q + sqrt(2 kappa beta); below one: proved
  D end;         // how near the zeros at both ends are to the points, at least
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
  const Mask good = (left > 0.0) & (r < proof.uniqueness) & (size < kLongest) &
                    (length(z) < kNorm) & (patch > 0.9) &
                    (length(z, 4) - 0.5 * length(d, 4) > r * kOutward);
  proof.measure = good ? proof.measure : larger(proof.measure, splat(2.0));
  return proof;
}

// Where a branch is: at `row` and `part` of 2^`level` steps to the next row.
struct Cursor {
  Branch* branch = nullptr;
  int row = 0, level = 0;
  std::int64_t part = 0;
  double z[N];
  double end = 0.0;  // how near the proved zero is
  // The points before at the same step, the last one first.
  double before[2][N];
  int known = 0;
  int successes = 0;  // blocks in a row that were kept whole
  // The block that is being tried.
  int count = 0;
  double point[kBlock][N], from[kBlock][kConstraints], to[kBlock][kConstraints];
  double measure[kBlock], ends[kBlock], uniqueness[kBlock];
};

INLINE void value_at(const Branch& b, int row, std::int64_t part, int level, double* out) {
  const double* v = b.values + std::ptrdiff_t{row} * kConstraints;
  if (part == 0) {
    std::copy(v, v + kConstraints, out);
    return;
  }
  const double t = std::ldexp(static_cast<double>(part), -level);
  for (int k = 0; k < kConstraints; ++k) out[k] = v[k] + t * (v[k + kConstraints] - v[k]);
}

INLINE void advance(int& row, std::int64_t& part, int level) {
  if (++part == std::int64_t{1} << level) {
    part = 0;
    ++row;
  }
}

class Follower {
 public:
  Follower(const MovingSystem& system, const FollowOptions& options, Branch* branches, int count)
      : system_(system), options_(options), next_(branches), last_(branches + count) {}

  void run() {
    for (Cursor& cursor : cursors_) refill(cursor);
    while (true) {
      bool active = false;
      for (Cursor& cursor : cursors_) active |= cursor.branch != nullptr;
      if (!active) return;
      march();
      if (options_.certify) prove_blocks();
      for (Cursor& cursor : cursors_)
        if (cursor.branch) settle(cursor);
    }
  }

 private:
  // Newton's method for all lanes at their values; false for those where it does not converge.
  void newton(const D* c, D* z, bool* converged) {
    const D first = newton_step(system_, c, z);
    D step = first;
    for (int i = 1; i < kNewtonSteps; ++i) {
      // A lane that is done stays as it is, so that no branch depends on the others.
      const Mask busy = (step >= kConverged) & (step < kDiverged);
      bool any = false;
      for (int l = 0; l < W; ++l) any |= busy[l] != 0;
      if (!any) break;
      D moved[N];
      std::copy(z, z + N, moved);
      const D next = newton_step(system_, c, moved);
      step = busy ? next : step;
      for (int k = 0; k < N; ++k) z[k] = busy ? moved[k] : z[k];
    }
    for (int l = 0; l < W; ++l) converged[l] = step[l] < kConverged && first[l] < kDiverged;
  }

  void coefficients(const D* values, D* c) const {
    for (int k = 0; k < kConstraints; ++k) c[k] = coefficient(system_.equation[k], values[k]);
  }

  // Gives a free lane the next branch that has a solution near its start.
  void refill(Cursor& cursor) {
    cursor.branch = nullptr;
    while (next_ != last_) {
      Branch& b = *next_++;
      b.stop = Stop::kStart;
      b.reached = -1;
      b.fraction = 0.0;
      b.segments = b.tries = 0;
      b.worst = 0.0;
      D z[N], v[kConstraints], c[kConstraints];
      bool converged[W];
      for (int i = 0; i < N; ++i) z[i] = splat(b.start[i]);
      for (int k = 0; k < kConstraints; ++k) v[k] = splat(b.values[k]);
      coefficients(v, c);
      newton(c, z, converged);
      if (!converged[0]) continue;
      cursor = Cursor{};
      cursor.branch = &b;
      for (int i = 0; i < N; ++i) {
        cursor.z[i] = b.point[i] = b.last[i] = b.previous[i] = z[i][0];
      }
      b.reached = 0;
      if (b.rows > 1) return;
      b.stop = Stop::kEnd;
      cursor.branch = nullptr;
    }
  }

  // Follows each branch for a block of steps.
  void march() {
    D now[N], before[2][N];
    int known[W], row[W], level[W];
    std::int64_t part[W];
    bool going[W];
    for (int l = 0; l < W; ++l) {
      const Cursor& cursor = cursors_[l];
      going[l] = cursor.branch != nullptr;
      // An idle lane repeats the first busy one.
      const Cursor& source = going[l] ? cursor : busy();
      row[l] = source.row;
      part[l] = source.part;
      level[l] = source.level;
      known[l] = source.known;
      for (int i = 0; i < N; ++i) {
        now[i][l] = source.z[i];
        for (int j = 0; j < 2; ++j) before[j][i][l] = j < known[l] ? source.before[j][i] : source.z[i];
      }
      cursors_[l].count = 0;
    }
    for (int s = 0; s < kBlock; ++s) {
      D v[kConstraints], c[kConstraints], z[N], w1, w2;
      bool any = false;
      for (int l = 0; l < W; ++l) {
        Cursor& cursor = cursors_[l];
        // One step less from an odd part, so that the step can be doubled afterwards.
        const int steps = kBlock - static_cast<int>(cursor.part % 2);
        going[l] = going[l] && s < steps && row[l] + 1 < cursor.branch->rows;
        if (going[l]) {
          value_at(*cursor.branch, row[l], part[l], level[l], cursor.from[s]);
          advance(row[l], part[l], level[l]);
          value_at(*cursor.branch, row[l], part[l], level[l], cursor.to[s]);
          for (int k = 0; k < kConstraints; ++k) v[k][l] = cursor.to[s][k];
          any = true;
        }
        // Weights of the points before: of a parabola, a line or nothing.
        w1[l] = known[l] == 0 ? 0.0 : known[l] == 1 ? -1.0 : -3.0;
        w2[l] = known[l] == 2 ? 1.0 : 0.0;
      }
      if (!any) return;
      for (int l = 0; l < W; ++l)
        if (!going[l]) {
          const int other = static_cast<int>(std::find(going, going + W, true) - going);
          for (int k = 0; k < kConstraints; ++k) v[k][l] = v[k][other];
          for (int i = 0; i < N; ++i) {
            now[i][l] = now[i][other];
            before[0][i][l] = before[0][i][other];
            before[1][i][l] = before[1][i][other];
          }
          w1[l] = w1[other];
          w2[l] = w2[other];
        }
      coefficients(v, c);
      const D w0 = 1.0 - w1 - w2;
      for (int i = 0; i < N; ++i) z[i] = w0 * now[i] + w1 * before[0][i] + w2 * before[1][i];
      bool converged[W];
      newton(c, z, converged);
      for (int l = 0; l < W; ++l) {
        if (!going[l]) continue;
        going[l] = converged[l];
        Cursor& cursor = cursors_[l];
        cursor.measure[s] = converged[l] ? 0.0 : kGaveUp;
        ++cursor.count;
        for (int i = 0; i < N; ++i) cursor.point[s][i] = z[i][l];
        known[l] = std::min(known[l] + 1, 2);
      }
      for (int i = 0; i < N; ++i) {
        before[1][i] = before[0][i];
        before[0][i] = now[i];
        now[i] = z[i];
      }
    }
  }

  const Cursor& busy() const {
    return *std::find_if(cursors_, cursors_ + W, [](const Cursor& c) { return c.branch; });
  }

  // Proves all steps of the blocks, eight of any branches at a time.
  void prove_blocks() {
    struct Step {
      Cursor* cursor;
      int index;
    } steps[W];
    int filled = 0;
    const auto flush = [&] {
      if (!filled) return;
      D from[kConstraints], to[kConstraints], z0[N], z1[N];
      for (int l = 0; l < W; ++l) {
        const Step& step = steps[l < filled ? l : 0];
        const Cursor& cursor = *step.cursor;
        const double* start = step.index ? cursor.point[step.index - 1] : cursor.z;
        for (int i = 0; i < N; ++i) {
          z0[i][l] = start[i];
          z1[i][l] = cursor.point[step.index][i];
        }
        for (int k = 0; k < kConstraints; ++k) {
          from[k][l] = cursor.from[step.index][k];
          to[k][l] = cursor.to[step.index][k];
        }
      }
      const Proof proof = prove(system_, from, to, z0, z1);
      for (int l = 0; l < filled; ++l) {
        Cursor& cursor = *steps[l].cursor;
        const int s = steps[l].index;
        cursor.measure[s] = proof.measure[l];
        cursor.ends[s] = proof.end[l];
        cursor.uniqueness[s] = proof.uniqueness[l];
        ++cursor.branch->tries;
      }
      filled = 0;
    };
    for (Cursor& cursor : cursors_) {
      if (!cursor.branch) continue;
      for (int s = 0; s < cursor.count; ++s) {
        if (cursor.measure[s] == kGaveUp) break;
        steps[filled++] = {&cursor, s};
        if (filled == W) flush();
      }
    }
    flush();
  }

  // Keeps the steps that hold, and chooses the next step size.
  void settle(Cursor& cursor) {
    Branch& b = *cursor.branch;
    double worst = 0.0;
    int s = 0;
    for (; s < cursor.count; ++s) {
      const double measure = cursor.measure[s];
      if (options_.certify) {
        // Points are scaled to another patch: a factor of at most four.
        const bool joined = 4.0 * cursor.end + 0x1p-40 < cursor.uniqueness[s];
        if (!(measure < kProved && joined)) break;
        cursor.end = cursor.ends[s];
        worst = std::max(worst, measure);
      } else {
        if (measure == kGaveUp || distance(cursor.z, cursor.point[s]) > kLongest) break;
        ++b.tries;
      }
      ++b.segments;
      cursor.known = std::min(cursor.known + 1, 2);
      std::copy(cursor.before[0], cursor.before[0] + N, cursor.before[1]);
      std::copy(cursor.z, cursor.z + N, cursor.before[0]);
      std::copy(cursor.point[s], cursor.point[s] + N, cursor.z);
      advance(cursor.row, cursor.part, cursor.level);
      if (cursor.part == 0)
        std::copy(cursor.z, cursor.z + N, b.point + std::ptrdiff_t{cursor.row} * N);
    }
    b.worst = std::max(b.worst, worst);
    if (cursor.row + 1 >= b.rows) return finish(cursor, Stop::kEnd);
    if (s == cursor.count) {
      ++cursor.successes;
      if (cursor.level > 0 && cursor.part % 2 == 0 &&
          (worst < kEasy || cursor.successes >= kPatience)) {
        cursor.successes = 0;
        --cursor.level;
        cursor.part /= 2;
        // Of three points in a row the outer two are as far apart as the next step.
        if (cursor.known == 2) std::copy(cursor.before[1], cursor.before[1] + N, cursor.before[0]);
        cursor.known = cursor.known == 2 ? 1 : 0;
      }
      return;
    }
    cursor.successes = 0;
    // The measure is about proportional to the step.
    const double measure = cursor.measure[s];
    int halvings = 1;
    if (measure == kGaveUp || !(measure < 8.0))
      halvings = 3;
    else if (measure > 1.6)
      halvings = 2;
    if (cursor.level >= options_.most_halvings) return finish(cursor, Stop::kStep);
    halvings = std::min(halvings, options_.most_halvings - cursor.level);
    cursor.level += halvings;
    cursor.part <<= halvings;
    const double scale = std::ldexp(1.0, -halvings);
    if (cursor.known)
      for (int i = 0; i < N; ++i)
        cursor.before[0][i] = cursor.z[i] + scale * (cursor.before[0][i] - cursor.z[i]);
    cursor.known = std::min(cursor.known, 1);
  }

  static double distance(const double* a, const double* b) {
    double s = 0.0;
    for (int i = 0; i < N; ++i) s += (a[i] - b[i]) * (a[i] - b[i]);
    return std::sqrt(s);
  }

  void finish(Cursor& cursor, Stop stop) {
    Branch& b = *cursor.branch;
    b.stop = stop;
    b.reached = cursor.row;
    b.fraction = std::ldexp(static_cast<double>(cursor.part), -cursor.level);
    std::copy(cursor.z, cursor.z + N, b.last);
    std::copy(cursor.known ? cursor.before[0] : cursor.z,
              (cursor.known ? cursor.before[0] : cursor.z) + N, b.previous);
    refill(cursor);
  }

  static constexpr double kGaveUp = 1e300;
  const MovingSystem& system_;
  const FollowOptions options_;
  Branch *next_, *last_;
  Cursor cursors_[W];
};

}  // namespace

void GSP_FOLLOW(const MovingSystem& system, const FollowOptions& options, Branch* branches,
                int count) {
  Follower(system, options, branches, count).run();
}

}  // namespace gsp
