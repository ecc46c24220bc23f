// Adaptive tracking of several paths at a time, one in each lane of a vector.
//
// A step evaluates the Taylor series of every lane at its own step length. The last term is summed
// as a geometric series (a Pade approximant with the common pole). Then Newton's method corrects
// the point twice. In lanes whose corrections contract enough, the next Taylor series is computed
// with the second factorization. (With the first factorization the series would have a relative
// error proportional to the first correction, and steps would be short wherever paths bend.)
#include <algorithm>
#include <type_traits>

#include "factorization.hpp"
#include "forms.hpp"
#include "steps.hpp"

namespace gsp {
namespace {

// Values, gradients and products of series of quadrics on the Study quadric.

// The sum over i + j = k of products of the coefficients of two series.
struct Pairs {
  C ee[10], ef[4][4], ff;
};

// The products of x with itself, alone or added to others.
template <bool alone>
INLINE void take_square(Pairs& p, const C* x) {
  take_square<alone>(p.ee, x);
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) take_product<alone>(p.ef[i][j], x[i], x[4 + j]);
  C s = alone ? C{} : p.ff;
  for (int i = 4; i < N; ++i) add_product(s, x[i], x[i]);
  p.ff = s;
}

// The products of x with y and of y with x, likewise.
template <bool alone>
INLINE void take_both(Pairs& p, const C* x, const C* y) {
  take_both<alone>(p.ee, x, y);
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) {
      C s = p.ef[i][j];
      take_product<alone>(s, x[i], y[4 + j]);
      add_product(s, y[i], x[4 + j]);
      p.ef[i][j] = s;
    }
  C s = alone ? C{} : p.ff;
  for (int i = 4; i < N; ++i) add_product(s, x[i] + x[i], y[i]);
  p.ff = s;
}

// The sum over i + j = k of the products of terms i and j > 0 of a series, for k > 1.
INLINE void take_between(Pairs& p, const C (*series)[N], int k) {
  if (k == 2) return take_square<true>(p, series[1]);
  take_both<true>(p, series[1], series[k - 1]);
  for (int i = 2; 2 * i < k; ++i) take_both<false>(p, series[i], series[k - i]);
  if (k % 2 == 0) take_square<false>(p, series[k / 2]);
}

INLINE void features(const Pairs& p, C* phi) {
  for (int i = 0; i < 10; ++i) phi[i] = p.ee[i];
  for (int i = 1; i < 4; ++i) {
    const int j = i % 3 + 1, k = j % 3 + 1;
    const C d = p.ef[0][i] - p.ef[i][0], x = p.ef[j][k] - p.ef[k][j];
    phi[kOffsetT + i - 1] = d + x;
    phi[kOffsetU + i - 1] = d - x;
  }
  int n = kOffsetS;
  for (int i = 0; i < 4; ++i)
    for (int j = i + 1; j < 4; ++j) phi[n++] = p.ef[i][j] + p.ef[j][i];
  for (int i = 1; i < 4; ++i) phi[n++] = p.ef[i][i];
  phi[kOffsetRho] = p.ff;
}

// Calls f(begin, end) for the ranges of features that a quadric uses.
template <class F>
INLINE void ranges(unsigned groups, F&& f) {
  f(0, 10);
  if (groups & kT) f(kOffsetT, kOffsetT + 3);
  if (groups & kU) f(kOffsetU, kOffsetU + 3);
  if (groups & kS) f(kOffsetS, kOffsetS + 9);
  if (groups & kRho) f(kOffsetRho, kOffsetRho + 1);
}

#if defined(GSP_REAL)
using Equations = RealHomotopy;
using Line = RealLine;
using Number = V;
INLINE V change_of(const Line& q, int i) { return splat(q.change[i]); }
INLINE V number(const Line& q, int i, const V& t) { return q.start[i] + t * q.change[i]; }
INLINE V start_of(const Line& q, int i) { return splat(q.start[i]); }
INLINE V value_change(const Equations& H, int i) { return splat(H.value_change[i]); }
INLINE V value_at(const Equations& H, int i, const V& t) {
  return H.value_start[i] + t * H.value_change[i];
}
INLINE Complex tau_change(const Equations& H, int i) { return H.tau_change[i]; }
INLINE C tau(const Equations& H, int i, const V& t) {
  const Complex from = H.tau_start[i], by = H.tau_change[i];
  return {from.re + t * by.re, from.im + t * by.im};
}
#else
using Equations = Homotopy;
using Line = Quadric;
using Number = C;
INLINE auto change_of(const Line& q, int i) { return change_of(q.change, q.more, i); }
INLINE C number(const Line& q, int i, const V& t) { return line(q.start, q.change, q.more, i, t); }
INLINE const Complex& start_of(const Line& q, int i) { return q.start[i]; }
// Values are in the quadrics.
INLINE V value_change(const Equations&, int) { return splat(0.0); }
INLINE V value_at(const Equations&, int, const V&) { return splat(0.0); }
INLINE auto tau_change(const Equations& H, int i) {
  return change_of(H.tau_change, H.tau_more, i);
}
INLINE C tau(const Equations& H, int i, const V& t) {
  return line(H.tau_start, H.tau_change, H.tau_more, i, t);
}
#endif
constexpr bool kReal = std::is_same_v<Equations, RealHomotopy>;

// change.y
INLINE C change(const Line& q, const C* y) {
  C r{};
  ranges(q.groups, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) add_product(r, change_of(q, i), y[i]);
  });
  return r;
}
// start.x + change.y
INLINE C value(const Line& q, const C* x, const C* y) {
  C s{}, r{};
  ranges(q.groups, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      add_product(s, start_of(q, i), x[i]);
      add_product(r, change_of(q, i), y[i]);
    }
  });
  return s + r;
}

// A quadric at one t: its second derivatives by e, by e and f, and by f.
struct Hessian {
  Number ee[10], ef[4][4], ff;
};

INLINE void hessian(const Line& q, const V& t, Hessian& h) {
  int n = 0;
  for (int i = 0; i < 4; ++i) {
    const Number c = number(q, n, t);
    h.ee[n++] = c + c;
    for (int j = i + 1; j < 4; ++j, ++n) h.ee[n] = number(q, n, t);
  }
  if (q.groups & (kT | kU | kS)) {
    for (int i = 1; i < 4; ++i) {
      Number a{}, b{};  // of e0 f_i - e_i f0 and of (e x f)_i
      if (q.groups & kT) a = b = number(q, kOffsetT + i - 1, t);
      if (q.groups & kU) {
        const Number u = number(q, kOffsetU + i - 1, t);
        a = a + u;
        b = b - u;
      }
      const int j = i % 3 + 1, k = j % 3 + 1;
      h.ef[0][i] = a, h.ef[i][0] = Number{} - a;
      h.ef[j][k] = b, h.ef[k][j] = Number{} - b;
    }
  }
  if (q.groups & kS) {
    n = kOffsetS;
    h.ef[0][0] = Number{};
    for (int i = 0; i < 4; ++i)
      for (int j = i + 1; j < 4; ++j) {
        const Number c = number(q, n++, t);
        h.ef[i][j] = h.ef[i][j] + c, h.ef[j][i] = h.ef[j][i] + c;
      }
    for (int i = 1; i < 4; ++i) h.ef[i][i] = number(q, n++, t);
  }
  if (q.groups & kRho) {
    const Number c = number(q, kOffsetRho, t);
    h.ff = c + c;
  }
}

// g_e = ee e + ef f and g_f = ef^T e.
template <bool diagonal>
INLINE void add_mixed(const Hessian& h, const C* e, const C* f, C* g) {
  for (int i = 0; i < 4; ++i) {
    C s = g[i];
    for (int j = 0; j < 4; ++j)
      if (diagonal ? i + j > 0 : i != j) add_product(s, h.ef[i][j], f[j]);
    g[i] = s;
  }
  for (int i = 0; i < 4; ++i) {
    C s{};
    for (int j = 0; j < 4; ++j)
      if (diagonal ? i + j > 0 : i != j) add_product(s, h.ef[j][i], e[j]);
    g[4 + i] = s;
  }
}

// The gradient of a quadric at z; returns its value.
INLINE C gradient(unsigned groups, const Hessian& h, const C* z, C* g) {
  constexpr int kPlace[4][4] = {{0, 1, 2, 3}, {1, 4, 5, 6}, {2, 5, 7, 8}, {3, 6, 8, 9}};
  const C *e = z, *f = z + 4;
  for (int i = 0; i < 4; ++i) {
    C s{};
    for (int j = 0; j < 4; ++j) add_product(s, h.ee[kPlace[i][j]], e[j]);
    g[i] = s;
    g[4 + i] = C{};
  }
  if (groups & kS)
    add_mixed<true>(h, e, f, g);
  else if (groups & (kT | kU))
    add_mixed<false>(h, e, f, g);
  if (groups & kRho)
    for (int i = 0; i < 4; ++i) add_product(g[4 + i], h.ff, f[i]);
  C s{}, r{};
  for (int i = 0; i < 4; ++i) add_product(s, g[i], e[i]), add_product(r, g[4 + i], f[i]);
  s = s + r;
  return {0.5 * s.re, 0.5 * s.im};
}

// The seven equations, their Jacobian matrix, its factorization and solutions with it.
//
// Points are in C^8 of norm 1. The Jacobian matrix J has seven rows with J z = 0 on solutions, so
// least-norm solutions of J dz = b are orthogonal to z: the row conj(z).dz = 0 of a moving patch is
// satisfied without being stated.

constexpr int kRows = kEquations + 1;
#if !defined(GSP_ORDER)
#define GSP_ORDER 7
#endif
constexpr int kOrder = GSP_ORDER;  // of the Taylor series

// The numbers of one step in all lanes.
struct Workspace {
  C row[kRows][N];        // of the Jacobian matrix, then of R; row 0 is that of e.f
  C lower[kRows][kRows];  // L below its diagonal
  V inverse[kRows];       // of the squares of the lengths of R's rows
  V magnitude[kRows];     // of the terms that cancel in the values
  C factor[kQuadrics][N]; // gradients of the factors of products
  C f[kRows];             // values
  Hessian hessian[kQuadrics];  // at t, where `go` went
  C tau[kEquations];
  V value[kEquations];    // imaginary parts of quadrics that are real but for a multiple of N
  // Series of the factors and of N, for products.
  C g[kEquations][kOrder + 1], h[kEquations][kOrder + 1], n[kOrder + 1];
};

// s += i a b
INLINE void add_times_i(C& s, const V& a, const C& b) {
  s.re -= a * b.im;
  s.im += a * b.re;
}

INLINE C study(const C* z) {
  C s{};
  for (int i = 0; i < 4; ++i) add_product(s, z[i], z[4 + i]);
  return s;
}

// The equations at t.
void go(const Equations& H, Workspace& w, const V& t) {
  for (int i = 0; i < kEquations; ++i) {
    hessian(H.quadric[i], t, w.hessian[i]);
    if (H.product[i]) {
      hessian(H.quadric[i + kEquations], t, w.hessian[i + kEquations]);
      w.tau[i] = tau(H, i, t);
    } else if constexpr (kReal) {
      w.value[i] = value_at(H, i, t);
    }
  }
}

// The product of two factors: (A + iB) (A - iB) if A and B are what is known.
INLINE C product_of(const C& g, const C& h) { return kReal ? g * g + h * h : g * h; }

// Values and Jacobian matrix at z.
void linearize(const Equations& H, Workspace& w, const C* z) {
  C n{};
  for (int j = 0; j < 4; ++j) add_product(n, z[j], z[j]);
  w.n[0] = n;
  w.f[0] = study(z);
  w.magnitude[0] = splat(1.0);
  for (int i = 0; i < N; ++i) w.row[0][i] = z[(i + 4) % N];
  for (int i = 0; i < kEquations; ++i) {
    C* row = w.row[i + 1];
    if (!H.product[i]) {
      C g = gradient(H.quadric[i].groups, w.hessian[i], z, row);
      if constexpr (kReal) {
        add_times_i(g, w.value[i], n);
        const V twice = w.value[i] + w.value[i];
        for (int j = 0; j < 4; ++j) add_times_i(row[j], twice, z[j]);
      }
      w.f[i + 1] = g;
      w.magnitude[i + 1] = splat(1.0);
      continue;
    }
    C *dg = w.factor[i], *dh = w.factor[i + kEquations];
    const C g = gradient(H.quadric[i].groups, w.hessian[i], z, dg);
    const C h = gradient(H.quadric[i + kEquations].groups, w.hessian[i + kEquations], z, dh);
    const C tau_n = w.tau[i] * n;
    w.g[i][0] = g;
    w.h[i][0] = h;
    w.f[i + 1] = product_of(g, h) - tau_n * n;
    const V factors = square(g) + square(h);
    w.magnitude[i + 1] = root((kReal ? factors + factors : factors) + square(tau_n));
    const C by_g = kReal ? g + g : h, by_h = kReal ? h + h : g;
    const C by_n = splat(4.0) * tau_n;
    for (int j = 0; j < N; ++j) {
      C s = by_g * dg[j];
      add_product(s, by_h, dh[j]);
      if (j < 4) subtract_product(s, by_n, z[j]);
      row[j] = s;
    }
  }
}

// J = L R; the rows of J become those of R.
void factorize(Workspace& w) { factorize<kRows>(w.row, w.lower, w.inverse); }

// b becomes L^-1 b.
void substitute(const Workspace& w, C* b) {
  for (int i = 1; i < kRows; ++i) {
    C s = b[i];
    for (int j = 0; j < i; ++j) subtract_product(s, w.lower[i][j], b[j]);
    b[i] = s;
  }
}

// The solution of J x = b of the least norm; b is used up.
void solve(const Workspace& w, C* b, C* x) {
  substitute(w, b);
  for (int j = 0; j < kRows; ++j) b[j] = w.inverse[j] * b[j];
  for (int k = 0; k < N; ++k) {
    Sum sum{};
    for (int j = 0; j < kRows; ++j) sum.add(w.row[j][k], b[j]);
    x[k] = sum.conjugate_total();
  }
}

// About how far rounding in the values moves a solution: the least-norm solution of J x = b for
// one b of the size of the rounding errors, with phases in general position.
V rounding(const Workspace& w) {
  constexpr double kPhase[kRows][2] = {{1.0, 0.0},   {-0.54, 0.84}, {0.28, 0.96}, {-0.8, -0.6},
                                       {0.6, -0.8},  {0.96, 0.28},  {-0.28, 0.96}};
  C b[kRows];
  for (int i = 0; i < kRows; ++i) {
    const V size = kEpsilon * w.magnitude[i];
    b[i] = {kPhase[i][0] * size, kPhase[i][1] * size};
  }
  substitute(w, b);
  V s = w.inverse[0] * square(b[0]);
  for (int i = 1; i < kRows; ++i) s += w.inverse[i] * square(b[i]);
  return root(s);
}

// The Taylor series of paths, from the factors of the Jacobian matrix at their start.

// Of order k in the product of two series.
INLINE C coefficient(const C* a, const C* b, int k) {
  C s{};
  if (a == b) {
    for (int j = 0; 2 * j < k; ++j) add_product(s, a[j], a[k - j]);
    s = s + s;
    if (k % 2 == 0) add_product(s, a[k / 2], a[k / 2]);
    return s;
  }
  for (int j = 0; j <= k; ++j) add_product(s, a[j], b[k - j]);
  return s;
}

// The Taylor series of the paths through series[0] at t, with the factorization that linearize()
// and factorize() have left.
void expand(const Equations& H, Workspace& w, const V& t, C (*series)[N]) {
  Pairs pairs;
  C phi[kFeatures], before[kFeatures], mixed[kFeatures], b[kRows];
  take_square<true>(pairs, series[0]);
  features(pairs, before);
  bool any_product = kReal;
  for (int i = 0; i < kEquations; ++i) any_product |= H.product[i];
  C square_before = w.n[0] * w.n[0];  // the coefficient of N^2 before
  for (int k = 1; k <= kOrder; ++k) {
    const bool bent = k > 1;  // with terms that are not linear
    b[0] = C{};
    if (bent) {
      take_between(pairs, series, k);
      features(pairs, phi);
      for (int i = 0; i < kFeatures; ++i) {
        mixed[i].re = t * phi[i].re + before[i].re;
        mixed[i].im = t * phi[i].im + before[i].im;
      }
      for (int i = 0; i < 4; ++i) b[0] = b[0] - pairs.ef[i][i];
    }
    const auto given = [&](const Line& q) {
      return bent ? value(q, phi, mixed) : change(q, before);
    };
    C square_now{};
    if (any_product) {
      w.n[k] = bent ? norm_form(pairs.ee) : C{};
      square_now = coefficient(w.n, w.n, k);
    }
    for (int i = 0; i < kEquations; ++i) {
      C g = given(H.quadric[i]);
      if (!H.product[i]) {
        if constexpr (kReal) {
          add_times_i(g, w.value[i], w.n[k]);
          add_times_i(g, value_change(H, i), w.n[k - 1]);
        }
        b[i + 1] = C{} - g;
        continue;
      }
      w.g[i][k] = g;
      w.h[i][k] = given(H.quadric[i + kEquations]);
      const C s = kReal ? coefficient(w.g[i], w.g[i], k) + coefficient(w.h[i], w.h[i], k)
                        : coefficient(w.g[i], w.h[i], k);
      b[i + 1] = w.tau[i] * square_now - s;
      add_product(b[i + 1], tau_change(H, i), square_before);
    }
    C* x = series[k];
    solve(w, b, x);
    if (k == kOrder) break;
    // Complete the terms of order k by those that are linear in x.
    for (int i = 0; i < kEquations; ++i) {
      if (!H.product[i]) continue;
      for (int j = 0; j < N; ++j) {
        add_product(w.g[i][k], w.factor[i][j], x[j]);
        add_product(w.h[i][k], w.factor[i + kEquations][j], x[j]);
      }
    }
    if (bent)
      take_both<false>(pairs, series[0], x);
    else
      take_both<true>(pairs, series[0], x);
    if (any_product) {
      w.n[k] = norm_form(pairs.ee);
      square_before = coefficient(w.n, w.n, k);
    }
    features(pairs, before);
  }
}

// The state of the paths under way.
struct Lanes : Steps<kOrder> {
  C series[kOrder + 1][N];
  C waypoint[N];
  Mask passed;  // the waypoint
  std::int32_t last[W];  // of the steps
  int path[W];  // -1: idle
  std::int32_t steps[W];
};

// The series at the next step, its last term summed as a geometric series.
INLINE void predict(const Lanes& s, C* z) {
  const V step = s.next - s.t;
  const C top = s.top();
  for (int i = 0; i < N; ++i) {
    C x = top * s.series[kOrder][i];
    for (int k = kOrder; k-- > 0;) {
      x.re = x.re * step + s.series[k][i].re;
      x.im = x.im * step + s.series[k][i].im;
    }
    z[i] = x;
  }
}

// A lane becomes scale (high + low), as far as there are digits for it; low is that of coordinate i.
INLINE void put_all([[maybe_unused]] C& x, [[maybe_unused]] int l, [[maybe_unused]] double scale,
                    [[maybe_unused]] const Complex& high, [[maybe_unused]] const Complex* low) {
#if GSP_PARTS > 1
  V re = splat(high.re), im = splat(high.im);
  for (int k = 0; k < kMore; ++k) {
    re += splat(low[k * N].re);
    im += splat(low[k * N].im);
  }
  const D factor = D{} + scale;
  re = factor * re, im = factor * im;
  for (int k = 0; k < GSP_PARTS; ++k) {
    set_part(x.re, l, k, part_of(re, l, k));
    set_part(x.im, l, k, part_of(im, l, k));
  }
#endif
}

// Multiplies the last three terms of a series by the number that it returns: 1, or a small one in lanes
// where squares of their lengths would overflow. With 32 digits that is so 1e-24 before a branch point.
INLINE V shorten([[maybe_unused]] C (*terms)[N]) {
  V scale = splat(1.0);
#if GSP_PARTS > 1
  constexpr double kShort = 0x1p-332;
  C shorter[3][N];
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < N; ++i) shorter[k][i] = by(D{} + kShort, terms[k][i]);
  const Mask is_long = norm(shorter[2]) > splat(0x1p-32);
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < N; ++i) terms[k][i] = select(is_long, shorter[k][i], terms[k][i]);
  scale = select(is_long, splat(kShort), scale);
#endif
  return scale;
}

INLINE void normalize(C* z) {
  const V scale = 1.0 / norm(z);
  for (int i = 0; i < N; ++i) z[i] = scale * z[i];
}

INLINE void store_low([[maybe_unused]] const C& x, [[maybe_unused]] int l, Complex* low) {
  for (int k = 0; k < kMore; ++k) low[k * N] = {0.0, 0.0};
#if GSP_PARTS > 1
  for (int k = 1; k < GSP_PARTS; ++k)
    low[(k - 1) * N] = {part_of(x.re, l, k), part_of(x.im, l, k)};
#endif
}

// Stores a point of norm 1.
INLINE void store(const C* z, int l, int path, const Results& out) {
  for (int i = 0; i < N; ++i) {
    out.point[path * N + i] = lane(z[i], l);
    if (out.low) store_low(z[i], l, out.low + path * kMore * N + i);
  }
}

constexpr int kRefinements = 4;
constexpr double kSettled = 250.0 * kEpsilon;

// Newton's method at t = 1, for as many end points as there are lanes.
void refine(const Equations& H, Workspace& w, int count, const int* index, const Results& out) {
  C z[N];
  for (int i = 0; i < N; ++i)
    for (int l = 0; l < W; ++l) {
      const int p = index[l < count ? l : 0], k = p * N + i;
      put(z[i], l, out.point[k]);
      if (out.low) put_all(z[i], l, 1.0, out.point[k], out.low + p * kMore * N + i);
    }
  go(H, w, splat(1.0));
  V last = splat(1.0);
  // A lane that has converged is not changed while others continue.
  bool going = true;
  for (int k = 0; k < kRefinements && going; ++k) {
    C dz[N], moved[N];
    linearize(H, w, z);
    factorize(w);
    solve(w, w.f, dz);
    for (int i = 0; i < N; ++i) moved[i] = z[i] - dz[i];
    normalize(moved);
    const Mask settled = last < kSettled;
    for (int i = 0; i < N; ++i) z[i] = select(settled, z[i], moved[i]);
    last = select(settled, last, norm(dz));
    going = false;
    for (int l = 0; l < W; ++l) going |= !(lane(last, l) < kSettled);
  }
  linearize(H, w, z);
  factorize(w);
  // Frobenius norms of the inverse of J, with the equations divided by their magnitude and
  // undivided.
  V condition = splat(0.0), curvature = splat(0.0);
  for (int c = 0; c < kRows; ++c) {
    C x[kRows];
    inverse_column<kRows>(w.lower, c, x);
    V column = w.inverse[c];
    for (int i = c + 1; i < kRows; ++i) column += w.inverse[i] * square(x[i]);
    curvature += column;
    condition += w.magnitude[c] * w.magnitude[c] * column;
  }
  condition = root(condition);
  curvature = root(curvature);
  V residual = square(w.f[0]);
  for (int i = 1; i < kRows; ++i)
    residual = maximum(residual, square(w.f[i]) / (w.magnitude[i] * w.magnitude[i]));
  residual = root(residual);
  for (int l = 0; l < count; ++l) {
    const int p = index[l];
    store(z, l, p, out);
    out.condition[p] = lane(condition, l);
    out.curvature[p] = lane(curvature, l);
    out.residual[p] = lane(residual, l);
    out.correction[p] = lane(last, l);
  }
}

class Tracker {
 public:
  Tracker(const Equations& homotopy, const Options& options, int paths, const Complex* points,
          const Complex* low, const double* left, const Results& out)
      : H(homotopy),
        options_(options),
        paths_(paths),
        points_(points),
        low_(low),
        left_(left),
        out_(out) {}

  void run() {
    for (int l = 0; l < W; ++l) load(l);
    while (under_way_ > 0) {
      C z[N];
      V n1, n2, noise;
      predict(s, z);
      normalize(z);
      correct(z, n1, n2, noise);
      const Mask accepted = judge(n1, n2, noise);
      s.learn(n1, n2, noise, accepted);
      renew(z, accepted);
      const V arrived = s.next;
      advance(accepted);
      retire_lanes(z, arrived, accepted);
    }
    refine_all();
  }

 private:
  // The next path into a lane that does not start at the target.
  void load(int l) {
    for (;;) {
      s.path[l] = upcoming_ < paths_ ? upcoming_++ : -1;
      place(l);
      if (s.path[l] < 0 || !left_ || left_[s.path[l]] > 0.0) break;
      s.steps[l] = 0;
      record(l, kRegular, s.series[0], 0.0);
    }
    if (s.path[l] >= 0) ++under_way_;
    s.begin(l);
    if (left_ && s.path[l] >= 0) s.start_before_end(l, left_[s.path[l]]);
    s.passed[l] = 0;
    s.steps[l] = 0;
    s.last[l] = options_.max_steps;
  }

  // The start of its path into a lane.
  void place(int l) {
    const Complex* z = points_ + (s.path[l] >= 0 ? s.path[l] : 0) * N;
    double size = 0.0;
    for (int i = 0; i < N; ++i) size += z[i].re * z[i].re + z[i].im * z[i].im;
    const double scale = 1.0 / __builtin_sqrt(size);
    for (int i = 0; i < N; ++i) {
      for (int k = 0; k <= kOrder; ++k) put(s.series[k][i], l, {0.0, 0.0});
      put(s.series[0][i], l, {z[i].re * scale, z[i].im * scale});
      if (low_) put_all(s.series[0][i], l, scale, z[i], low_ + (z - points_) * kMore + i);
    }
  }

  void finish(int l, Status status, const C* z, double left) {
    record(l, status, z, left);
    --under_way_;
    load(l);
  }

  void record(int l, Status status, const C* z, double left) {
    const int p = s.path[l];
    store(z, l, p, out_);
    out_.left[p] = left;
    out_.status[p] = status;
    out_.steps[p] = s.steps[l];
    out_.condition[p] = out_.curvature[p] = out_.residual[p] = out_.correction[p] = -1.0;
  }

  // Two steps of Newton's method at s.next: their lengths, and that of what rounding causes.
  INLINE void correct(C* z, V& n1, V& n2, V& noise) {
    C first[N], second[N];
    go(H, w, s.next);
    linearize(H, w, z);
    factorize(w);
    solve(w, w.f, first);
    for (int i = 0; i < N; ++i) z[i] = z[i] - first[i];
    linearize(H, w, z);
    factorize(w);
    solve(w, w.f, second);
    for (int i = 0; i < N; ++i) z[i] = z[i] - second[i];
    normalize(z);
    n1 = norm(first), n2 = norm(second);
    noise = rounding(w);
  }

  Aims aims() const {
    return {options_.predictor_tolerance, options_.contraction, options_.radius_fraction};
  }

  // Which lanes accept the step.
  INLINE Mask judge(const V& n1, const V& n2, const V& noise) const {
    Mask accepted = s.judge(aims(), n1, n2, noise);
    accepted = accepted & ((s.next < 1.0) | (n2 <= options_.arrival));
    for (int l = 0; l < W; ++l)
      if (s.path[l] < 0) accepted[l] = 0;
    return accepted;
  }

  // The series at z, kept in the lanes that accepted the step.
  INLINE void renew(const C* z, const Mask& accepted) {
    C series[kOrder + 1][N];
    for (int i = 0; i < N; ++i) series[0][i] = z[i];
    expand(H, w, s.next, series);
    for (int k = 0; k <= kOrder; ++k)
      for (int i = 0; i < N; ++i) s.series[k][i] = select(accepted, series[k][i], s.series[k][i]);
    const V scale = shorten(series + kOrder - 2);
    C product{};
    for (int i = 0; i < N; ++i)
      add_conjugate_product(product, series[kOrder - 1][i], series[kOrder][i]);
    s.expand({norm(series[kOrder]), norm(series[kOrder - 1]), norm(series[kOrder - 2]),
              product},
             accepted);
    s.leading = select(accepted, s.leading / scale, s.leading);
  }

  // The next step, which stops at the waypoint.
  INLINE void advance(const Mask& accepted) {
    const double waypoint = 1.0 - options_.waypoint;
    s.advance(aims(), accepted);
    const Mask over = accepted & (s.t < waypoint) & (s.next > waypoint) & (s.next < 1.0);
    s.next = select(over, splat(waypoint), s.next);
  }

  // Counts the step in each lane, and ends the paths that have arrived or cannot go on.
  INLINE void retire_lanes(const C* z, const V& arrived, const Mask& accepted) {
    const V ahead = s.next - s.t;
    const double waypoint = 1.0 - options_.waypoint;
    // With all digits: in doubles 1 - 1e-20 is equal to 1.
    const Mask there = arrived >= 1.0;
    const V left = 1.0 - s.t;
    const Mask near = (left < options_.nearest) & (s.next < 1.0);
    for (int l = 0; l < W; ++l) {
      if (s.path[l] < 0) continue;
      ++s.steps[l];
      if (accepted[l]) {
        if (there[l]) {
          finish(l, kRegular, z, 0.0);
          continue;
        }
        if (options_.waypoint > 0.0 && lane(arrived, l) == waypoint) {
          s.passed[l] = -1;
          s.last[l] = std::min(s.last[l], s.steps[l] + options_.late_steps);
          for (int i = 0; i < N; ++i) put(s.waypoint[i], l, lane(z[i], l));
        }
      }
      const bool stuck =
          !(lane(ahead, l) > options_.min_step) || s.steps[l] >= s.last[l];
      if (!stuck && !near[l]) continue;
      if (s.passed[l])
        finish(l, kSingular, s.waypoint, options_.waypoint);
      else
        finish(l, kFailed, s.series[0], lane(left, l));
    }
  }

  void refine_all() {
    int index[W], count = 0;
    for (int p = 0; p < paths_; ++p) {
      if (out_.status[p] == kRegular) index[count++] = p;
      if (count == W || (count > 0 && p == paths_ - 1)) {
        refine(H, w, count, index, out_);
        count = 0;
      }
    }
  }

  const Equations& H;
  const Options& options_;
  const int paths_;
  const Complex* const points_;
  const Complex* const low_;
  const double* const left_;
  const Results& out_;
  int upcoming_ = 0, under_way_ = 0;
  alignas(64) Workspace w;
  alignas(64) Lanes s;
};

}  // namespace

void GSP_TRACK(const Equations& homotopy, const Options& options, int paths, const Complex* points,
               const Complex* low, const double* left, const Results& results) {
  Tracker(homotopy, options, paths, points, low, left, results).run();
}

}  // namespace gsp
