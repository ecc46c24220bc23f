// Built with GSP_PARTS = 4: lanes of quadruple-double numbers.
#include "fine_points.hpp"

#include "combined_quadrics.hpp"

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

// One of four parts of numbers in lanes, of which there are six a part.
V in_lanes(const double* from, int k) {
  V x;
  for (int part = 0; part < kParts; ++part) x.part[part] = load(from, part * kEquations + k);
  return x;
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
    const V by = number(g.weight, kEquations, r) * in_lanes(value, r);
    C s = quadric[e.main] + by * quadric[0];
    if (e.squares[0] >= 0) s = quadric[0] * s;
    for (const int b : e.squares) {
      if (b < 0) continue;
      const C x = b == g.turned[r] ? in_lanes(distance, r) * quadric[b] : quadric[b];
      s = s - x * x;
    }
    put_value(r + 1, s);
  }
}

C load(const FinerNumbers& from, int k) {
  C x;
  for (int part = 0; part < kParts; ++part)
    x.re.part[part] = load(from.part[part].re, k), x.im.part[part] = load(from.part[part].im, k);
  return x;
}
void store(double* to, int k, const D& x) { __builtin_memcpy(to + k * W, &x, sizeof x); }
void store(const FinerNumbers& to, int k, const C& x) {
  for (int part = 0; part < kParts; ++part)
    store(to.part[part].re, k, x.re.part[part]), store(to.part[part].im, k, x.im.part[part]);
}
// Where a sum cancels to 2^-104 of its terms, its third part may be above 2^-104 of the first one: once more
// renormalized the first two have all but 2^-100 of the number.
DoubleDouble shortened(const V& x) {
  const V y = renormalized(x.part[0], x.part[1], x.part[2], x.part[3]);
  return exact_sum(y.part[0], y.part[1]);
}
void store(const FineNumbers& to, int k, const C& x) {
  const DoubleDouble re = shortened(x.re), im = shortened(x.im);
  store(to.high.re, k, re.hi), store(to.low.re, k, re.lo);
  store(to.high.im, k, im.hi), store(to.low.im, k, im.lo);
}

// The product of quaternions.
void product(const C* p, const C* q, C* out) {
  out[0] = p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3];
  for (int i = 0; i < 3; ++i) {
    const int a = i + 1, b = (i + 1) % 3 + 1, c = (i + 2) % 3 + 1;
    out[a] = p[0] * q[a] + p[a] * q[0] + p[b] * q[c] - p[c] * q[b];
  }
}

void place(const OwnFrames& frames, const FinerNumbers& point, double* patch) {
  C z[N], base[4] = {}, platform[4] = {}, ahead[4], behind[4];
  for (int i = 0; i < N; ++i) z[i] = load(point, i);
  for (int i = 0; i < 3; ++i) {
    base[i + 1] = {splat(frames.base[i]), splat(0.0)};
    platform[i + 1] = {splat(frames.platform[i]), splat(0.0)};
  }
  product(base, z, ahead), product(z, platform, behind);
  for (int i = 0; i < 4; ++i)
    z[4 + i] = splat(frames.unit) * z[4 + i] + splat(0.5) * (ahead[i] - behind[i]);
  C largest = z[0];
  D size = square(z[0]).part[0], index = D{};
  for (int i = 1; i < 4; ++i) {
    const D other = square(z[i]).part[0];
    const Mask more = other > size;
    largest = select(more, z[i], largest);
    index = more ? D{} + double(i) : index;
    size = more ? other : size;
  }
  const V inverse = 1.0 / square(largest);
  const C factor{inverse * largest.re, -(inverse * largest.im)}, one{splat(1.0), splat(0.0)};
  for (int i = 0; i < N; ++i) store(point, i, select(index == double(i), one, factor * z[i]));
  store(patch, 0, index);
}

// Adds a z_j to the derivative by z_i.
INLINE void add_scaled(C& s, const V& a, const C& z) { s = s + a * z; }

void gradient_at(const FinerQuadrics& g, int q, const C* z, C* out) {
  const int count = g.quadrics * kMonomials;
  for (int i = 0; i < N; ++i) out[i] = {splat(0.0), splat(0.0)};
  const auto coefficient = [&](int k, V& a) {
    const int at = q * kMonomials + k;
    // The first part is zero only if all are.
    if (g.coefficient[at] == 0.0) return false;
    a = number(g.coefficient, count, at);
    return true;
  };
  V a;
  for (int i = 0; i < 4; ++i)
    for (int j = i; j < N; ++j) {
      if (!coefficient(monomial(i, j), a)) continue;
      add_scaled(out[i], a, z[j]);
      add_scaled(out[j], a, z[i]);
    }
  if (coefficient(kMonomials - 1, a))
    for (int j = 4; j < N; ++j) add_scaled(out[j], a + a, z[j]);
}

void linearize(const FinerQuadrics& g, const FinerNumbers& point, const FineNumbers& values,
               const FineNumbers& derivatives) {
  C z[N], equation[kEquations + 1], row[kEquations + 1][N];
  Quadrics<C> quadrics;
  for (int i = 0; i < N; ++i) z[i] = load(point, i);
  for (int q = 0; q < g.quadrics; ++q) gradient_at(g, q, z, quadrics.gradient[q]);
  for (int q = 0; q < g.quadrics; ++q) {
    C s = z[0] * quadrics.gradient[q][0];
    for (int i = 1; i < N; ++i) s = s + z[i] * quadrics.gradient[q][i];
    quadrics.value[q] = half(s);
  }
  combine({g.quadrics, nullptr, nullptr, g.equation}, quadrics, -1.0, equation, row);
  for (int r = 0; r <= kEquations; ++r) {
    store(values, r, equation[r]);
    for (int i = 0; i < N; ++i) store(derivatives, r * N + i, row[r][i]);
  }
}

void move(const FinerNumbers& point, const FineNumbers& change) {
  for (int i = 0; i < N; ++i) {
    const C by{load(change.high.re, change.low.re, i), load(change.high.im, change.low.im, i)};
    store(point, i, load(point, i) - by);
  }
}

void motion(const FinerNumbers& point, const FineNumbers& out) {
  C z[N], moved[4], conjugate[4];
  for (int i = 0; i < N; ++i) z[i] = load(point, i);
  const auto twice = [](const C& x) { return x + x; };
  C square[4];
  for (int i = 0; i < 4; ++i) square[i] = z[i] * z[i], conjugate[i] = i ? C{-z[i].re, -z[i].im} : z[i];
  store(out, 0, square[0] + square[1] + square[2] + square[3]);
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    store(out, 1 + 4 * i, square[0] + square[i + 1] - square[j + 1] - square[k + 1]);
    const C skew = z[0] * z[k + 1], even = z[i + 1] * z[j + 1];
    store(out, 1 + 3 * i + j, twice(even - skew));
    store(out, 1 + 3 * j + i, twice(even + skew));
  }
  product(z + 4, conjugate, moved);
  for (int i = 0; i < 3; ++i) store(out, 10 + i, twice(moved[i + 1]));
}

}  // namespace

extern const FinerPoints GSP_FINER;
const FinerPoints GSP_FINER{values, place, linearize, move, motion};

}  // namespace gsp
