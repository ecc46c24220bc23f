#include "reduced_homotopy.hpp"

#include <cstddef>

#include "factorization.hpp"
#include "forms.hpp"
#include "lanes.hpp"
#include "steps.hpp"

namespace gsp {
namespace {

// The moving numbers on the paths of reduced_homotopy.hpp: only values, or all coefficients.

INLINE void add_real(C& s, double a, const C& b) {
  s.re += a * b.re;
  s.im += a * b.im;
}
INLINE void add_real(C& s, const V& a, const C& b) {
  s.re += a * b.re;
  s.im += a * b.im;
}
// s += i a b
INLINE void add_times_i(C& s, const V& a, const C& b) {
  s.re -= a * b.im;
  s.im += a * b.re;
}
INLINE C minus(const C& a) { return {-a.re, -a.im}; }
INLINE V minus(const V& a) { return -a; }
INLINE double minus(double a) { return -a; }
INLINE void subtract_times(C& s, double a, const C& b) {
  s.re -= a * b.re;
  s.im -= a * b.im;
}
INLINE void subtract_times(C& s, const V& a, const C& b) {
  s.re -= a * b.re;
  s.im -= a * b.im;
}
INLINE void subtract_times(C& s, const C& a, const C& b) { subtract_product(s, a, b); }

// Orders of a series that what is next in it depends on: products of e of the order without what is
// linear in it, and of the order before; N of both; the scalars of the order before.
struct Orders {
  const C *pairs, *before;
  const C &n, &n_before;
  const C* scalars;
};

// Forms and slopes of one geometry, the values moving from those of a start to those of a target,
// another in each lane.
struct MovingValues {
  static constexpr int kOrder = 3;  // of the Taylor series
  const ReducedGeometry& geometry;
  const ReducedPaths& paths;
  C from[kEquations]{}, change[kEquations]{}, v[kEquations]{};

  INLINE void load(int l, int target) {
    const int start = paths.start[target];
    for (int j = 0; j < kEquations; ++j) {
      const Complex a = paths.start_values[start * kEquations + j];
      const Complex b = paths.values[target * kEquations + j];
      put(from[j], l, a);
      put(change[j], l, {b.re - a.re, b.im - a.im});
    }
  }
  INLINE void go(const V& t) {
    for (int j = 0; j < kEquations; ++j) {
      v[j].re = from[j].re + t * change[j].re;
      v[j].im = from[j].im + t * change[j].im;
    }
  }
  INLINE void arrive(int l, int target) {
    for (int j = 0; j < kEquations; ++j) put(v[j], l, paths.values[target * kEquations + j]);
  }

  // Half the gradient of form j minus its value times N.
  INLINE void half_gradient(int j, const C* e, C* half) const {
    const double* c = geometry.form[j];
    for (int a = 0; a < 4; ++a) {
      half[a] = C{};
      subtract_product(half[a], v[j], e[a]);
    }
    for (int a = 0, k = 0; a < 4; ++a) {
      add_real(half[a], c[k++], e[a]);
      for (int b = a + 1; b < 4; ++b, ++k) {
        add_real(half[a], 0.5 * c[k], e[b]);
        add_real(half[b], 0.5 * c[k], e[a]);
      }
    }
  }
  INLINE double slope(int j, int l) const { return geometry.slope[j][l]; }
  // The negative of equation j in the next order.
  INLINE C next(int j, int order, const Orders& at) const {
    C s{};
    add_product(s, change[j], at.n_before);
    if (order == 1) return s;
    add_product(s, v[j], at.n);
    for (int i = 0; i < kForms; ++i) subtract_times(s, geometry.form[j][i], at.pairs[i]);
    return s;
  }
};

// All coefficients moving from those of a start to those of one target; values are in the forms.
template <int M>
struct MovingGeometry {
  static constexpr int kOrder = 4;
  const ReducedGeometry& geometry;
  const ReducedPaths& paths;
  C form[kEquations][kForms]{}, slopes[kEquations][M > 0 ? M : 1]{};

  INLINE void load(int, int) {}
  INLINE void go(const V& t) {
    const ReducedLine& line = *paths.line;
    const auto at = [&](const Complex& from, const Complex& change) {
      return C{from.re + t * change.re, from.im + t * change.im};
    };
    for (int j = 0; j < kEquations; ++j) {
      for (int i = 0; i < kForms; ++i) form[j][i] = at(line.form[j][i], line.form_change[j][i]);
      for (int l = 0; l < M; ++l) slopes[j][l] = at(line.slope[j][l], line.slope_change[j][l]);
    }
  }
  INLINE void arrive(int, int) { go(splat(1.0)); }

  INLINE void half_gradient(int j, const C* e, C* half) const {
    const C* c = form[j];
    for (int a = 0; a < 4; ++a) half[a] = C{};
    for (int a = 0, k = 0; a < 4; ++a) {
      add_product(half[a], c[k++], e[a]);
      for (int b = a + 1; b < 4; ++b, ++k) {
        const C entry{0.5 * c[k].re, 0.5 * c[k].im};
        add_product(half[a], entry, e[b]);
        add_product(half[b], entry, e[a]);
      }
    }
  }
  INLINE const C& slope(int j, int l) const { return slopes[j][l]; }
  INLINE C next(int j, int order, const Orders& at) const {
    const ReducedLine& line = *paths.line;
    C s{};
    for (int i = 0; i < kForms; ++i) add_product(s, line.form_change[j][i], at.before[i]);
    for (int l = 0; l < M; ++l) add_product(s, line.slope_change[j][l], at.scalars[l]);
    if (order > 1)
      for (int i = 0; i < kForms; ++i) add_product(s, form[j][i], at.pairs[i]);
    return minus(s);
  }
};

// The same where only values are complex.
template <int M>
struct MovingPlatform {
  static constexpr int kOrder = 3;
  const ReducedGeometry& geometry;
  const ReducedPaths& paths;
  V form[kEquations][kForms]{}, slopes[kEquations][M > 0 ? M : 1]{};
  V v[kEquations]{};  // imaginary parts: the real ones are in the forms

  INLINE void load(int, int) {}
  INLINE void go(const V& t) {
    const ReducedLine& line = *paths.line;
    for (int j = 0; j < kEquations; ++j) {
      for (int i = 0; i < kForms; ++i)
        form[j][i] = line.form[j][i].re + t * line.form_change[j][i].re;
      for (int l = 0; l < M; ++l) slopes[j][l] = line.slope[j][l].re + t * line.slope_change[j][l].re;
      v[j] = line.value[j] + t * line.value_change[j];
    }
  }
  INLINE void arrive(int, int) { go(splat(1.0)); }

  INLINE void half_gradient(int j, const C* e, C* half) const {
    const V* c = form[j];
    for (int a = 0; a < 4; ++a) {
      half[a] = {v[j] * e[a].im, -(v[j] * e[a].re)};
    }
    for (int a = 0, k = 0; a < 4; ++a) {
      add_real(half[a], c[k++], e[a]);
      for (int b = a + 1; b < 4; ++b, ++k) {
        const V entry = 0.5 * c[k];
        add_real(half[a], entry, e[b]);
        add_real(half[b], entry, e[a]);
      }
    }
  }
  INLINE const V& slope(int j, int l) const { return slopes[j][l]; }
  INLINE C next(int j, int order, const Orders& at) const {
    const ReducedLine& line = *paths.line;
    C s{};
    add_times_i(s, splat(line.value_change[j]), at.n_before);
    for (int i = 0; i < kForms; ++i) subtract_times(s, line.form_change[j][i].re, at.before[i]);
    for (int l = 0; l < M; ++l) subtract_times(s, line.slope_change[j][l].re, at.scalars[l]);
    if (order == 1) return s;
    add_times_i(s, v[j], at.n);
    for (int i = 0; i < kForms; ++i) subtract_times(s, form[j][i], at.pairs[i]);
    return s;
  }
};

// The equations of reduced_homotopy.hpp, their derivatives and the Taylor series of paths, one in each lane.

INLINE C conjugate(const C& a) { return {a.re, -a.im}; }
INLINE C number_of(const C& a) { return a; }
INLINE C number_of(const V& a) { return {a, splat(0.0)}; }
INLINE C number_of(double a) { return {splat(a), splat(0.0)}; }

// r += (e ^ w), four components of which three are independent where e is not zero.
INLINE void add_wedge(C* r, const C* w, const C* e) {
  add_product(r[0], e[1], w[3]), add_product(r[0], e[2], w[4]), add_product(r[0], e[3], w[5]);
  subtract_product(r[1], e[0], w[3]), add_product(r[1], e[2], w[2]), subtract_product(r[1], e[3], w[1]);
  subtract_product(r[2], e[0], w[4]), add_product(r[2], e[3], w[0]), subtract_product(r[2], e[1], w[2]);
  subtract_product(r[3], e[0], w[5]), add_product(r[3], e[1], w[1]), subtract_product(r[3], e[2], w[0]);
}
// Coordinate k of w is in component `plus` times e[plus_e], in `minus` times -e[minus_e].
struct Wedge {
  int plus, plus_e, minus, minus_e;
};
constexpr Wedge kWedge[6] = {{2, 3, 3, 2}, {3, 1, 1, 3}, {1, 2, 2, 1},
                             {0, 1, 1, 0}, {0, 2, 2, 0}, {0, 3, 3, 0}};

// The vectors from which a series in D coordinates is computed.
template <int D>
struct Expansion {
  C x[D];                     // where it is expanded
  C q[kQuantities], n;        // values of the quantities and of N there
  C slope[kQuantities][4];    // derivatives of the quantities by e
  C row[D][D], lower[D][D];   // of the Jacobian matrix, then of its factors R and L
  V inverse[D];               // of the squares of the lengths of R's rows

  // The numbers of one path in a lane.
  INLINE void give(int l, double* out) const {
    const V* const given = reinterpret_cast<const V*>(this);
    for (std::size_t i = 0; i < sizeof(Expansion) / sizeof(V); ++i) out[i] = lane(given[i], l);
  }
  INLINE void take(int l, const double* given) {
    V* const to = reinterpret_cast<V*>(this);
    for (std::size_t i = 0; i < sizeof(Expansion) / sizeof(V); ++i) put(to[i], l, given[i]);
  }
};

// The equations in e and M scalars: 4 of e ^ w, with h the quadric of w, then those without pivots.
template <int M, bool has_h, class Moving>
struct System : Expansion<4 + M> {
  // Coordinates; pivots; the first equation without a pivot.
  static constexpr int kOrder = Moving::kOrder;
  static constexpr int D = 4 + M, P = (has_h ? 7 : 6) - M, F = has_h ? 5 : 4;
  using At = Expansion<D>;
  using At::inverse, At::lower, At::n, At::q, At::row, At::slope, At::x;

  const ReducedGeometry& geometry;
  Moving moving;
  C f[D];                     // values of the equations

  System(const ReducedGeometry& given, const ReducedPaths& paths)
      : geometry(given), moving{given, paths} {}

  // The quantities, equations and Jacobian matrix at z.
  void linearize(const C* z) {
    measure(z);
    values();
    derivatives();
  }

  // The quantities and their derivatives at z.
  void measure(const C* z) {
    const C* const e = x;
    for (int i = 0; i < D; ++i) x[i] = z[i];
    n = C{};
    for (int i = 0; i < 4; ++i) add_product(n, e[i], e[i]);
    for (int j = 0; j < kEquations; ++j) {
      C half[4], value{};
      moving.half_gradient(j, e, half);
      for (int a = 0; a < 4; ++a) add_product(value, e[a], half[a]);
      if (j >= P) {
        f[F + j - P] = value;
        for (int a = 0; a < 4; ++a) row[F + j - P][a] = half[a] + half[a];
        for (int l = 0; l < M; ++l) {
          subtract_times(f[F + j - P], minus(moving.slope(j, l)), x[4 + l]);
          row[F + j - P][4 + l] = number_of(moving.slope(j, l));
        }
        continue;
      }
      const int k = geometry.pivot[j];
      q[k] = minus(value);
      for (int l = 0; l < M; ++l) subtract_times(q[k], moving.slope(j, l), x[4 + l]);
      for (int a = 0; a < 4; ++a) slope[k][a] = minus(half[a] + half[a]);
    }
    for (int l = 0; l < M; ++l) {
      const int k = geometry.free[l];
      q[k] = x[4 + l];
      for (int a = 0; a < 4; ++a) slope[k][a] = C{};
    }
  }

  INLINE void values() {
    for (int i = 0; i < F; ++i) f[i] = C{};
    add_wedge(f, q, x);
    if constexpr (!has_h) return;
    for (int k = 0; k < 6; ++k) add_product(f[4], q[k], q[k]);
    subtract_product(f[4], n, q[6]);
  }

  // The derivative of equation i by quantity k, times c, into a column.
  INLINE void add_quantity(int k, int column, const C& c) {
    if (has_h && k == 6) {
      subtract_product(row[4][column], n, c);
      return;
    }
    const Wedge& t = kWedge[k];
    add_product(row[t.plus][column], x[t.plus_e], c);
    subtract_product(row[t.minus][column], x[t.minus_e], c);
    if constexpr (has_h) add_product(row[4][column], q[k] + q[k], c);
  }
  template <class Real>
  INLINE void add_quantity(int k, int column, const Real& c) {
    if (has_h && k == 6) {
      add_real(row[4][column], minus(c), n);
      return;
    }
    const Wedge& t = kWedge[k];
    add_real(row[t.plus][column], c, x[t.plus_e]);
    add_real(row[t.minus][column], minus(c), x[t.minus_e]);
    if constexpr (has_h) add_real(row[4][column], 2.0 * c, q[k]);
  }

  INLINE void derivatives() {
    const C* w = q;
    const C zero{};
    const C skew[4][4] = {{zero, w[3], w[4], w[5]},
                          {minus(w[3]), zero, w[2], minus(w[1])},
                          {minus(w[4]), minus(w[2]), zero, w[0]},
                          {minus(w[5]), w[1], minus(w[0]), zero}};
    for (int i = 0; i < 4; ++i) {
      // The combination of e ^ w by e vanishes: the moving patch takes its place.
      for (int a = 0; a < 4; ++a) {
        row[i][a] = skew[i][a];
        add_product(row[i][a], conjugate(x[i]), conjugate(x[a]));
      }
      for (int l = 0; l < M; ++l) row[i][4 + l] = C{};
    }
    if constexpr (has_h) {
      for (int a = 0; a < 4; ++a) row[4][a] = minus((q[6] + q[6]) * x[a]);
      for (int l = 0; l < M; ++l) row[4][4 + l] = C{};
    }
    for (int j = 0; j < P; ++j) {
      const int k = geometry.pivot[j];
      for (int a = 0; a < 4; ++a) add_quantity(k, a, slope[k][a]);
      for (int l = 0; l < M; ++l) add_quantity(k, 4 + l, minus(moving.slope(j, l)));
    }
    for (int l = 0; l < M; ++l) add_quantity(geometry.free[l], 4 + l, 1.0);
  }

  void factorize() { gsp::factorize<D>(row, lower, inverse); }

  INLINE void solve(const C* given, C* result) const {
    C b[D];
    for (int i = 0; i < D; ++i) {
      C s = given[i];
      for (int j = 0; j < i; ++j) subtract_product(s, lower[i][j], b[j]);
      b[i] = s;
    }
    for (int i = 0; i < D; ++i) b[i] = inverse[i] * b[i];
    for (int k = 0; k < D; ++k) {
      C s{};
      for (int j = 0; j < D; ++j) add_conjugate_product(s, row[j][k], b[j]);
      result[k] = s;
    }
  }

  // The Taylor series of the path through x, with the factors of its Jacobian matrix.
  void expand(C (*series)[D]) const {
    C quantity[kOrder + 1][kQuantities], norm[kOrder + 1], before[kForms], pairs[kForms];
    for (int k = 0; k < kQuantities; ++k) quantity[0][k] = q[k];
    norm[0] = n;
    for (int i = 0; i < D; ++i) series[0][i] = x[i];
    take_square<true>(before, x);
    for (int k = 1; k <= kOrder; ++k) {
      norm[k] = C{};
      if (k > 1) {
        take_between(pairs, series, k);
        norm[k] = norm_form(pairs);
      }
      const Orders at{pairs, before, norm[k], norm[k - 1], series[k - 1] + 4};
      C b[D];
      for (int i = 0; i < D; ++i) b[i] = C{};
      C* now = quantity[k];
      for (int l = 0; l < M; ++l) now[geometry.free[l]] = C{};
      for (int j = 0; j < kEquations; ++j) {
        const C s = moving.next(j, k, at);
        if (j < P) now[geometry.pivot[j]] = s;
        else b[F + j - P] = s;
      }
      right_hand_side(k, series, quantity, norm, b);
      solve(b, series[k]);
      if (k == kOrder) break;
      complete(series[k], now, norm[k]);
      if (k > 1) {
        take_both<false>(pairs, x, series[k]);
        for (int i = 0; i < kForms; ++i) before[i] = pairs[i];
      } else {
        take_both<true>(before, x, series[k]);
      }
    }
  }

  // The sum over i + j = k of the products of terms i and j > 0 of a series, for k > 1.
  static INLINE void take_between(C* pairs, const C (*series)[D], int k) {
    if (k == 2) return take_square<true>(pairs, series[1]);
    take_both<true>(pairs, series[1], series[k - 1]);
    for (int i = 2; 2 * i < k; ++i) take_both<false>(pairs, series[i], series[k - i]);
    if (k % 2 == 0) take_square<false>(pairs, series[k / 2]);
  }

  // The negative of the equations of order k without the terms that are linear in that order.
  INLINE void right_hand_side(int k, const C (*series)[D], const C (*quantity)[kQuantities],
                              const C* norm, C* b) const {
    C wedge[4] = {};
    add_wedge(wedge, quantity[k], x);
    for (int i = 1; i < k; ++i) add_wedge(wedge, quantity[i], series[k - i]);
    for (int i = 0; i < 4; ++i) b[i] = minus(wedge[i]);
    if constexpr (!has_h) return;
    C quadric{};
    for (int p = 0; p < 6; ++p) add_product(quadric, q[p], quantity[k][p]);
    for (int i = 1; 2 * i < k; ++i)
      for (int p = 0; p < 6; ++p) add_product(quadric, quantity[i][p], quantity[k - i][p]);
    quadric = quadric + quadric;
    if (k % 2 == 0)
      for (int p = 0; p < 6; ++p) add_product(quadric, quantity[k / 2][p], quantity[k / 2][p]);
    for (int i = 0; i <= k; ++i) subtract_product(quadric, norm[i], quantity[k - i][6]);
    b[4] = minus(quadric);
  }

  // Adds the terms that are linear in the order.
  INLINE void complete(const C* y, C* now, C& norm) const {
    for (int j = 0; j < P; ++j) {
      const int k = geometry.pivot[j];
      for (int a = 0; a < 4; ++a) add_product(now[k], slope[k][a], y[a]);
      for (int l = 0; l < M; ++l) subtract_times(now[k], moving.slope(j, l), y[4 + l]);
    }
    for (int l = 0; l < M; ++l) now[geometry.free[l]] = y[4 + l];
    for (int a = 0; a < 4; ++a) add_product(norm, x[a] + x[a], y[a]);
  }
};

// The Study point of a solution: N times e and f.
template <int M, bool has_h, class Moving>
void to_study(const System<M, has_h, Moving>& s, C* z) {
  const C *e = s.x, *w = s.q;
  C* f = z + 4;
  for (int i = 0; i < 4; ++i) z[i] = s.n * e[i], f[i] = C{};
  subtract_product(f[0], e[1], w[0]), subtract_product(f[0], e[2], w[1]), subtract_product(f[0], e[3], w[2]);
  add_product(f[1], e[0], w[0]), subtract_product(f[1], e[2], w[5]), add_product(f[1], e[3], w[4]);
  add_product(f[2], e[0], w[1]), add_product(f[2], e[1], w[5]), subtract_product(f[2], e[3], w[3]);
  add_product(f[3], e[0], w[2]), subtract_product(f[3], e[1], w[4]), add_product(f[3], e[2], w[3]);
}

// Tracking of the paths of reduced_homotopy.hpp, one in each lane; included by reduced_homotopy.cpp in each of its builds.

// Corrections as long as this are rounding, where the Jacobian matrix is not nearly singular.
constexpr double kRounding = 1e-12;
// Below this correction the next one is lost in rounding, but next to double ends.
constexpr double kSettled = 1e-8;
constexpr int kLastSteps = 4;

template <int M, bool has_h, class Moving>
class ReducedTracker {
  static constexpr int D = 4 + M, kOrder = Moving::kOrder;
  static constexpr int kKept = sizeof(Expansion<D>) / sizeof(V);  // of each path at its start

 public:
  ReducedTracker(const ReducedGeometry& geometry, const ReducedOptions& options, const ReducedPaths& paths,
             int begin, int end, const ReducedEnds& ends)
      : options_(options), paths_(paths), ends_(ends), upcoming_(begin * paths.paths),
        first_(begin * paths.paths), last_(end * paths.paths),
        at_start_(new double[paths.paths * kKept]), w(geometry, paths) {}
  ~ReducedTracker() { delete[] at_start_; }
  ReducedTracker(const ReducedTracker&) = delete;
  ReducedTracker& operator=(const ReducedTracker&) = delete;

  void run() {
    for (int k = 0; k <= kOrder; ++k)
      for (int i = 0; i < D; ++i) series_[k][i] = C{};
    Mask loaded{};
    for (int l = 0; l < W; ++l) loaded[l] = load(l);
    renew(loaded);
    while (under_way_ > 0) renew(step());
    for (int p = first_; p < last_; p += W) refine(p);
  }

 private:
  // Paths are numbered in the order of their targets; their ends are stored by target.
  int target_of(int path) const { return paths_.order[path / paths_.paths]; }
  int place_of(int path) const {
    return target_of(path) * paths_.paths + path % paths_.paths;
  }

  // The next path into a lane, at its start; -1 unless there is none: then 0.
  long long load(int l) {
    path_[l] = upcoming_ < last_ ? upcoming_++ : -1;
    steps_[l] = 0;
    s.begin(l);
    if (path_[l] < 0) return 0;
    ++under_way_;
    loaded_ = true;
    const int target = target_of(path_[l]), k = path_[l] % paths_.paths;
    if (paths_.start[target] != start_) prepare(target);
    w.take(l, at_start_ + k * kKept);
    w.moving.load(l, target);
    return -1;
  }

  // The equations of a target's start at its solutions.
  void prepare(int target) {
    start_ = paths_.start[target];
    System<M, has_h, Moving> system(w.geometry, paths_);
    for (int l = 0; l < W; ++l) system.moving.load(l, target);
    system.moving.go(splat(0.0));
    for (int k = 0; k < paths_.paths; k += W) {
      C z[D];
      for (int l = 0; l < W; ++l) {
        const int path = k + l < paths_.paths ? k + l : k;
        const Complex* const point = paths_.starts + (start_ * paths_.paths + path) * D;
        for (int i = 0; i < D; ++i) put(z[i], l, point[i]);
      }
      system.linearize(z);
      system.factorize();
      for (int l = 0; l < W && k + l < paths_.paths; ++l)
        system.give(l, at_start_ + (k + l) * kKept);
    }
  }

  // Its end; returns as `load`.
  long long finish(int l, Status status) {
    const int p = place_of(path_[l]);
    for (int i = 0; i < D; ++i) ends_.point[p * D + i] = lane(w.x[i], l);
    ends_.status[p] = status;
    ends_.steps[p] = steps_[l];
    --under_way_;
    return load(l);
  }

  // e of norm 1; the scalars are quadratic.
  static INLINE void normalize(C* z) {
    V size = square(z[0]);
    for (int i = 1; i < 4; ++i) size += square(z[i]);
    const V scale = 1.0 / size, factor = root(scale);
    for (int i = 0; i < 4; ++i) z[i] = factor * z[i];
    for (int i = 4; i < D; ++i) z[i] = scale * z[i];
  }

  // Of changes, relative for scalars larger than 1.
  INLINE V length(const C* z, const V& weight) const {
    V scalars = splat(0.0);
    for (int i = 4; i < D; ++i) scalars += square(z[i]);
    V size = weight * scalars;
    for (int i = 0; i < 4; ++i) size += square(z[i]);
    return root(size);
  }

  // How long corrections are from rounding.
  INLINE V rounding(const V& weight) const {
    V most = w.inverse[0];
    for (int i = 1; i < D; ++i) most = maximum(most, w.inverse[i]);
    return maximum(splat(kRounding), kEpsilon * root(most / weight));
  }

  INLINE void predict(C* z) const {
    const V step = s.next - s.t;
    const C top = s.top();
    for (int i = 0; i < D; ++i) {
      z[i] = top * series_[kOrder][i];
      for (int k = kOrder; k-- > 0;) {
        z[i].re = z[i].re * step + series_[k][i].re;
        z[i].im = z[i].im * step + series_[k][i].im;
      }
    }
    normalize(z);
  }

  // Returns which lanes are at points that they have no series for.
  Mask step() {
    C z[D], first[D], second[D];
    predict(z);
    w.moving.go(s.next);
    const V weight = weigh(z);
    w.linearize(z);
    w.factorize();
    w.solve(w.f, first);
    for (int i = 0; i < D; ++i) z[i] = z[i] - first[i];
    w.linearize(z);
    w.factorize();
    w.solve(w.f, second);
    const V n1 = length(first, weight), n2 = length(second, weight), noise = rounding(weight);
    const Mask accepted = s.judge(aims(), n1, n2, noise);
    // What the second correction changes in the factors is of second order.
    for (int i = 0; i < D; ++i) w.x[i] = w.x[i] - second[i];
    s.learn(n1, n2, noise, accepted);
    return retire_lanes(accepted);
  }

  Aims aims() const {
    return {options_.predictor_tolerance, options_.contraction, options_.radius_fraction};
  }

  static INLINE V weigh(const C* z) {
    V sum = splat(1.0);
    for (int i = 4; i < D; ++i) sum += square(z[i]);
    return 1.0 / sum;
  }

  // The series in some lanes, and how far the next step goes in all.
  INLINE void renew(const Mask& chosen) {
    if (loaded_) w.moving.go(s.next);  // else it is there
    loaded_ = false;
    C series[kOrder + 1][D];
    w.expand(series);
    for (int k = 0; k <= kOrder; ++k)
      for (int i = 0; i < D; ++i) series_[k][i] = select(chosen, series[k][i], series_[k][i]);
    const V weight = weigh(w.x);
    const C *last = series[kOrder], *second = series[kOrder - 1];
    C product{}, scalars{};
    for (int i = 0; i < 4; ++i) add_conjugate_product(product, second[i], last[i]);
    for (int i = 4; i < D; ++i) add_conjugate_product(scalars, second[i], last[i]);
    s.expand({length(last, weight), length(second, weight), length(series[kOrder - 2], weight),
              product + weight * scalars},
             chosen);
    s.advance(aims(), chosen);
  }

  // Lanes whose paths are at their ends take the next; returns as `step`.
  INLINE Mask retire_lanes(const Mask& accepted) {
    Mask chosen = accepted;
    const V gone = s.next - s.t, arrived = s.next;
    for (int l = 0; l < W; ++l) {
      chosen[l] = path_[l] < 0 ? 0 : chosen[l];
      if (path_[l] < 0) continue;
      ++steps_[l];
      if (accepted[l] && lane(arrived, l) == 1.0)
        chosen[l] = finish(l, kRegular);
      else if (!(lane(gone, l) > options_.min_step) || steps_[l] >= options_.max_steps)
        chosen[l] = finish(l, kFailed);
    }
    return chosen;
  }

  // The last steps of Newton's method, and the Study points, of as many ends as there are lanes.
  // Long steps of the path leave errors of which a single one is too few.
  void refine(int begin) {
    C z[D], change[D], study[N];
    for (int l = 0; l < W; ++l) {
      const int path = begin + l < last_ ? begin + l : last_ - 1, p = place_of(path);
      for (int i = 0; i < D; ++i) put(z[i], l, ends_.point[p * D + i]);
      w.moving.arrive(l, target_of(path));
    }
    for (int left = kLastSteps, again = 1; left && again; --left) {
      w.linearize(z);
      w.factorize();
      w.solve(w.f, change);
      const V size = length(change, weigh(z));
      for (int i = 0; i < D; ++i) z[i] = z[i] - change[i];
      again = 0;
      for (int l = 0; l < W; ++l) again |= lane(size, l) > kSettled;
    }
    normalize(z);
    w.measure(z);
    to_study(w, study);
    for (int l = 0; l < W && begin + l < last_; ++l) {
      const int p = place_of(begin + l);
      for (int i = 0; i < D; ++i) ends_.point[p * D + i] = lane(z[i], l);
      for (int i = 0; i < N; ++i) ends_.study[p * N + i] = lane(study[i], l);
    }
  }

  const ReducedOptions& options_;
  const ReducedPaths& paths_;
  const ReducedEnds& ends_;
  int upcoming_;
  const int first_, last_;
  int under_way_ = 0;
  bool loaded_ = false;         // since the equations went where the steps go: another path
  int start_ = -1;              // which is prepared
  double* const at_start_;      // of its paths
  alignas(64) System<M, has_h, Moving> w;
  Steps<kOrder> s;
  C series_[kOrder + 1][D];
  int path_[W];
  std::int32_t steps_[W];
};

}  // namespace

void GSP_TRACK_VALUES(const ReducedGeometry& geometry, const ReducedOptions& options, const ReducedPaths& paths,
                    int begin, int end, const ReducedEnds& ends) {
  const auto run = [&]<int M, bool has_h>() {
    const auto with = [&]<class Moving>() {
      ReducedTracker<M, has_h, Moving>(geometry, options, paths, begin, end, ends).run();
    };
    if (!paths.line)
      with.template operator()<MovingValues>();
#if !defined(GSP_VALUES_ALONE)
    else if (paths.line->real)
      with.template operator()<MovingPlatform<M>>();
    else
      with.template operator()<MovingGeometry<M>>();
#endif
  };
  switch (2 * geometry.scalars + geometry.has_h) {
    case 0: return run.template operator()<0, false>();
    case 2: return run.template operator()<1, false>();
    case 4: return run.template operator()<2, false>();
    case 6: return run.template operator()<3, false>();
    case 3: return run.template operator()<1, true>();
    case 5: return run.template operator()<2, true>();
    case 7: return run.template operator()<3, true>();
  }
}

}  // namespace gsp
