// Built with GSP_PARTS = 2: lanes of double-double numbers.
#include "correct_rounding.hpp"
#include "pair.hpp"

namespace gsp {
namespace {

int monomial(int i, int j) { return i < 4 && j < 4 ? 4 * i - i * (i - 1) / 2 + j - i : 10 + 4 * i + j - 4; }

// A coefficient of the quadric z^T H z / 2, the Hessian matrix H given in two parts.
void put_coefficients(const Pair* hessian, double* high, double* low) {
  for (int i = 0; i < N; ++i)
    for (int j = i; j < N; ++j) {
      // Of f and f nothing but f . f is there.
      if (i > 4 || (i == 4 && j > 4)) continue;
      const int at = i == 4 ? kMonomials - 1 : monomial(i, j);
      const double factor = i == j ? 0.5 : 1.0;
      high[at] = factor * hessian[N * i + j].hi, low[at] = factor * hessian[N * i + j].lo;
    }
}

void coefficients(const FineGeometry& g, const FineValues& given, double* high, double* low) {
  Pair hessian[N * N];
  int equation[kMostQuadrics], turning[kMostQuadrics];
  for (int q = 0; q < g.quadrics; ++q) equation[q] = turning[q] = -1;
  for (int r = 0; r < kEquations; ++r) {
    equation[g.equation[r].main] = r;
    if (g.turned[r] >= 0) turning[g.turned[r]] = r;
  }
  for (int q = 0; q < g.quadrics; ++q) {
    for (int i = 0; i < N * N; ++i)
      hessian[i] = {g.hessian[q * N * N + i], g.hessian_low[q * N * N + i]};
    if (const int r = equation[q]; r >= 0) {
      const Pair shift = product({g.weight[r], g.weight_low[r]}, {given.value[r], given.value_low[r]});
      for (int i = 0; i < 4; ++i)
        hessian[i * (N + 1)] = sum(hessian[i * (N + 1)], {2.0 * shift.hi, 2.0 * shift.lo});
    }
    if (const int r = turning[q]; r >= 0)
      for (Pair& x : hessian) x = product(x, {given.distance[r], given.distance_low[r]});
    put_coefficients(hessian, high + q * kMonomials, low + q * kMonomials);
  }
}

void values(int quadrics, const ProofEquation* equations, const double* high, const double* low,
            const FineNumbers& point, const FineNumbers& monomials,
            const LaneNumbers& out) {
  C z[N], m[kMonomials], quadric[kMostQuadrics];
  for (int i = 0; i < N; ++i) z[i] = load(point, i);
  for (int i = 0; i < 4; ++i)
    for (int j = i; j < N; ++j) m[monomial(i, j)] = times(z[i], z[j]);
  m[kMonomials - 1] =
      plus(plus(times(z[4], z[4]), times(z[5], z[5])), plus(times(z[6], z[6]), times(z[7], z[7])));
  for (int k = 0; k < kMonomials; ++k) store(monomials, k, m[k]);
  for (int q = 0; q < quadrics; ++q) {
    Total re, im;
    for (int k = 0; k < kMonomials; ++k) {
      const double a = high[q * kMonomials + k], a_low = low[q * kMonomials + k];
      if (a == 0.0 && a_low == 0.0) continue;
      re.add(D{} + a, D{} + a_low, m[k].re);
      im.add(D{} + a, D{} + a_low, m[k].im);
    }
    quadric[q] = {re.total(), im.total()};
  }
  const auto put_value = [&](int r, const C& value) {
    store(out.re, r, value.re.hi + value.re.lo), store(out.im, r, value.im.hi + value.im.lo);
  };
  put_value(0, quadric[1]);
  for (int r = 0; r < kEquations; ++r) {
    const ProofEquation& e = equations[r];
    C s = quadric[e.main];
    if (e.squares[0] >= 0) s = times(quadric[0], s);
    for (const int b : e.squares)
      if (b >= 0) s = minus(s, times(quadric[b], quadric[b]));
    put_value(r + 1, s);
  }
}

// The monomials of e, and of e and f, less what a change of the point makes of them.
INLINE C moved(const FineNumbers& monomials, const FineNumbers& point, const LaneNumbers& change, int i,
               int j) {
  C m = load(monomials, monomial(i, j));
  const D a = load(point.high.re, i), b = load(point.high.im, i), c = load(point.high.re, j),
          d = load(point.high.im, j);
  const D p = load(change.re, i), q = load(change.im, i), r = load(change.re, j), s = load(change.im, j);
  // z_i c_j + (z_j - c_j) c_i
  const D u = c - r, v = d - s;
  m.re.lo -= (a * r - b * s) + (u * p - v * q);
  m.im.lo -= (a * s + b * r) + (u * q + v * p);
  return m;
}

// N, and N R by rows, N T (`study.motion`).
void motion(const FineNumbers& monomials, const FineNumbers& point, const LaneNumbers& change, C& norm,
            C* entry) {
  const auto e = [&](int i, int j) { return moved(monomials, point, change, i < j ? i : j, i < j ? j : i); };
  const auto of_f = [&](int i, int j) { return moved(monomials, point, change, i, 4 + j); };
  C square[4];
  for (int i = 0; i < 4; ++i) square[i] = e(i, i);
  norm = plus(plus(square[0], square[1]), plus(square[2], square[3]));
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    entry[4 * i] = minus(plus(square[0], square[i + 1]), plus(square[j + 1], square[k + 1]));
    const C skew = e(0, k + 1), even = e(i + 1, j + 1);
    entry[3 * i + j] = twice(minus(even, skew));
    entry[3 * j + i] = twice(plus(even, skew));
    // Of f times the conjugate of e.
    entry[kOfR + i] = twice(plus(minus(of_f(0, i + 1), of_f(i + 1, 0)),
                                 minus(of_f(j + 1, k + 1), of_f(k + 1, j + 1))));
  }
}

// How far the pose of a point may be from that of another within an error, and the quaternion.
struct Reach {
  D turning, moving, least;
};

// The error of f is in a unit; the forms of the pose err by kRounding times the sum of the moduli of their terms.
INLINE Reach reach_of(const C* z, const D& error, const D& unit, const C& norm) {
  D turning = D{}, moving = D{};
  for (int i = 0; i < 4; ++i) turning += bound(z[i]), moving += bound(z[4 + i]);
  const D all = turning + moving;
  const D e = turning;
  turning = 2.0 * turning * error + 8.0 * error * error + kRounding * turning * turning;
  moving = 2.0 * (unit * e + moving) * error + 8.0 * unit * error * error + kRounding * all * all;
  const D size = root(norm.re.hi * norm.re.hi + norm.im.hi * norm.im.hi);
  return {turning, moving, (1.0 - 0x1p-40) * size - kOutward * turning};
}

void poses(const FineNumbers& point, const FineNumbers& monomials, const LaneNumbers& change,
           const double* error, const double* f_unit, const double* real, const double* unit, const FinePoses& out) {
  C z[N], norm, entry[kEntries];
  for (int i = 0; i < N; ++i) {
    const C x = load(point, i);
    z[i] = {exact_sum(x.re.hi, x.re.lo - load(change.re, i)), exact_sum(x.im.hi, x.im.lo - load(change.im, i))};
  }
  motion(monomials, point, change, norm, entry);
  const D off = load(error, 0), of_f = load(f_unit, 0);
  const Mask is_real = load(real, 0) != 0.0;
  // Where N nearly vanishes, its low part may be as large as the high one.
  norm = {exact_sum(norm.re.hi, norm.re.lo), exact_sum(norm.im.hi, norm.im.lo)};
  // The real part is no further from a real solution.
  const V none{D{}, D{}};
  for (int i = 0; i < 4; ++i) z[i].im = select(is_real, none, z[i].im);
  norm.im = select(is_real, none, norm.im);
  for (int i = 0; i < kOfPose; ++i) entry[i].im = select(is_real, none, entry[i].im);
  const Reach reach = reach_of(z, off, of_f, norm);
  const C factor = inverse(norm), part = inverse(complex_root(norm));
  const D size = root(norm.re.hi * norm.re.hi + norm.im.hi * norm.im.hi), length = root(size);
  const D least = reach.least > 0.0 ? kOutward / reach.least : D{} + __builtin_inf();
  D errors[kEntries];
  for (int i = 0; i < kEntries; ++i) {
    D change_of;
    if (i < kOfPose) {
      entry[i] = times(factor, entry[i]);
      change_of = (i < kOfR ? reach.turning : reach.moving) + bound(entry[i]) * (reach.turning + kRounding * size);
    } else {
      // |sqrt(N') - sqrt(N)| <= |N' - N| / |sqrt(N)|.
      entry[i] = times(part, z[i - kOfPose]);
      change_of = length * off + bound(entry[i]) * (reach.turning + kRounding * size);
    }
    errors[i] = change_of * least;
  }
  put_rounded(entry, errors, is_real, load(unit, 0), out);
}

}  // namespace

extern const FinePoints GSP_FINE;
const FinePoints GSP_FINE{coefficients, values, poses};

}  // namespace gsp
