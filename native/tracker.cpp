// Adaptive tracking of several paths at a time, one in each lane of a vector.
//
// A step: evaluate the Taylor series of every lane at its own step length (the last term summed as
// a geometric series, a Pade approximant with the common pole), correct twice by Newton's method,
// and, in lanes where the corrections contract as they should, compute the next Taylor series with
// the second factorization. (With the first one the series inherits a relative error that is
// proportional to the first correction, and steps are short wherever paths bend.)
//
// The control of the step is that of S. Telen, M. Van Barel, J. Verschelde (A robust numerical path
// tracking algorithm for polynomial homotopy continuation, SIAM J. Sci. Comput. 42, 2020) and
// S. Timme (Mixed precision path tracking for polynomial homotopy continuation, Adv. Comput.
// Math. 47, 2021): the last terms of the series tell its radius of convergence and its error.
#include "newton.hpp"

namespace gsp {
namespace {

// A step is accepted if its first correction is not longer than this many times the aimed length:
// the prediction's error is estimated by its order of magnitude only.
constexpr double kSlack = 10.0;
// Corrections up to this many times what rounding causes are noise, and say nothing of contraction ...
constexpr double kNoise = 8.0;
// ... unless they are longer than this: then the matrix is too ill-conditioned to go on.
constexpr double kLongestNoise = 1e-6;
// By how much predictions have been worse than estimated: remembered from step to step with this
// factor, between the two bounds (no single step is trusted more than four digits).
constexpr double kSurplusMemory = 0.3;
constexpr double kLeastSurplus = 1e-4, kMostSurplus = 1e4;
// The measured curvature is halved from step to step unless it is measured anew.
constexpr double kBendMemory = 0.5;
// The next correction is to contract by this part of what is allowed.
constexpr double kContraction = 0.4;
// A rejected step is tried again with this part of its length.
constexpr double kRetry = 0.5;
// The last term is summed as a geometric series unless |1 - step / pole|^2 is smaller: there the
// step would go right into the pole, of which only the distance is known well.
constexpr double kIntoPole = 0.09;
// Added to norms, so that quotients of two that vanish are 1 where a path stands still.
constexpr double kTiny = 1e-100;

// The eighth root, of positive numbers.
INLINE V order_root(const V& x) {
  static_assert(kOrder + 1 == 8);
  return root(root(root(x)));
}

// The Taylor series of the paths through series[0] at t, with the factorization that linearize()
// and factorize() have left.
void expand(const Homotopy& H, Workspace& w, const V& t, C (*series)[N]) {
  Pairs pairs;
  C phi[kFeatures], before[kFeatures], mixed[kFeatures], b[kRows];
  clear(pairs);
  add_square(pairs, series[0]);
  features(pairs, before);
  bool any_product = false;
  for (int i = 0; i < kEquations; ++i) any_product |= H.product[i];
  for (int k = 1; k <= kOrder; ++k) {
    clear(pairs);
    for (int i = 1; 2 * i < k; ++i) add_both(pairs, series[i], series[k - i]);
    if (k % 2 == 0) add_square(pairs, series[k / 2]);
    features(pairs, phi);
    for (int i = 0; i < kFeatures; ++i) {
      mixed[i].re = t * phi[i].re + before[i].re;
      mixed[i].im = t * phi[i].im + before[i].im;
    }
    b[0] = C{};
    for (int i = 0; i < 4; ++i) b[0] = b[0] - pairs.ef[i][i];
    if (any_product) w.n[k] = norm_form(pairs);
    for (int i = 0; i < kEquations; ++i) {
      const C g = value(H.quadric[i], phi, mixed);
      if (!H.product[i]) {
        b[i + 1] = C{} - g;
        continue;
      }
      w.g[i][k] = g;
      w.h[i][k] = value(H.quadric[i + kEquations], phi, mixed);
      C s{}, n{}, m{};
      for (int j = 0; j <= k; ++j) {
        add_product(s, w.g[i][j], w.h[i][k - j]);
        add_product(n, w.n[j], w.n[k - j]);
        if (j < k) add_product(m, w.n[j], w.n[k - 1 - j]);
      }
      b[i + 1] = line(H.tau_start[i], H.tau_change[i], t) * n - s;
      add_product(b[i + 1], H.tau_change[i], m);
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
    add_both(pairs, series[0], x);
    w.n[k] = norm_form(pairs);
    features(pairs, before);
  }
}

// The state of the paths under way.
struct Lanes {
  C series[kOrder + 1][N];
  C pole;     // 1 / (common pole of the last two terms)
  V t, next;  // where the series is expanded; where the step goes
  V leading;  // the error of the prediction is about surplus * leading * step^(order + 1)
  V surplus;
  V bend;     // estimate of the norm of J^-1 D^2 F
  C waypoint[N];
  Mask passed;  // the waypoint
  int path[W];  // -1: idle
  std::int32_t steps[W];
};

// The series at `step`, its last term summed as a geometric series.
INLINE void predict(const Lanes& s, const V& step, C* z) {
  C d{1.0 - step * s.pole.re, -(step * s.pole.im)};
  const V size = square(d);
  const Mask far = size > kIntoPole;
  const V scale = 1.0 / size;
  C top = select(far, C{d.re * scale, -(d.im * scale)}, C{splat(1.0), splat(0.0)});
  for (int i = 0; i < N; ++i) {
    C x = top * s.series[kOrder][i];
    for (int k = kOrder; k-- > 0;) {
      x.re = x.re * step + s.series[k][i].re;
      x.im = x.im * step + s.series[k][i].im;
    }
    z[i] = x;
  }
}

INLINE void normalize(C* z) {
  const V scale = 1.0 / norm(z);
  for (int i = 0; i < N; ++i) z[i] = scale * z[i];
}

// A point of norm 1 goes out.
INLINE void store(const C* z, int l, int path, const Results& out) {
  for (int i = 0; i < N; ++i) {
    out.point[path * N + i] = lane(z[i], l);
    if (out.low) out.low[path * N + i] = low_lane(z[i], l);
  }
}

constexpr int kRefinements = 4;
constexpr double kSettled = 250.0 * kEpsilon;

// Newton's method at t = 1, for as many end points as there are lanes.
void refine(const Homotopy& H, Workspace& w, int count, const int* index, const Results& out) {
  C z[N];
  for (int i = 0; i < N; ++i)
    for (int l = 0; l < W; ++l) {
      const Complex& x = out.point[index[l < count ? l : 0] * N + i];
      put(z[i], l, x);
    }
  const V one = splat(1.0);
  V last = splat(1.0);
  // A lane that has converged stays as it is, whatever the others need.
  bool going = true;
  for (int k = 0; k < kRefinements && going; ++k) {
    C dz[N], moved[N];
    linearize(H, w, z, one);
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
  linearize(H, w, z, one);
  factorize(w);
  // Frobenius norms of the inverse of L, with the equations divided by their magnitude and as they
  // are.
  V condition = splat(0.0), curvature = splat(0.0);
  for (int c = 0; c < kRows; ++c) {
    C x[kRows];
    x[c] = {w.inverse[c], splat(0.0)};
    V column = square(x[c]);
    for (int i = c + 1; i < kRows; ++i) {
      C s{};
      for (int j = c; j < i; ++j) subtract_product(s, w.lower[i][j], x[j]);
      x[i] = w.inverse[i] * s;
      column += square(x[i]);
    }
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
  Tracker(const Homotopy& homotopy, const Options& options, int paths, const Complex* points,
          const Results& out)
      : H(homotopy), options_(options), paths_(paths), points_(points), out_(out) {}

  void run() {
    for (int l = 0; l < W; ++l) load(l);
    while (under_way_ > 0) {
      C z[N];
      V n1, n2, noise;
      const V step = s.next - s.t;
      predict(s, step, z);
      normalize(z);
      correct(z, n1, n2, noise);
      const Mask accepted = judge(n1, n2, noise);
      const V radius = renew(z, accepted);
      learn(step, n1, n2, noise, accepted);
      const V arrived = s.next;
      const V ahead = advance(step, radius, accepted);
      settle(z, arrived, ahead, accepted);
    }
    refine_all();
  }

 private:
  // The next path into a lane.
  void load(int l) {
    s.path[l] = upcoming_ < paths_ ? upcoming_++ : -1;
    if (s.path[l] >= 0) ++under_way_;
    const Complex* z = points_ + (s.path[l] >= 0 ? s.path[l] : 0) * N;
    double size = 0.0;
    for (int i = 0; i < N; ++i) size += z[i].re * z[i].re + z[i].im * z[i].im;
    const double scale = 1.0 / __builtin_sqrt(size);
    for (int i = 0; i < N; ++i) {
      for (int k = 0; k <= kOrder; ++k) put(s.series[k][i], l, {0.0, 0.0});
      put(s.series[0][i], l, {z[i].re * scale, z[i].im * scale});
    }
    // The first step goes nowhere: it corrects the start point and expands there.
    put(s.pole, l, {0.0, 0.0});
    V* const zero[] = {&s.t, &s.next, &s.leading, &s.bend};
    for (V* x : zero) put(*x, l, 0.0);
    put(s.surplus, l, 1.0);
    s.passed[l] = 0;
    s.steps[l] = 0;
  }

  void finish(int l, Status status, const C* z, double t) {
    const int p = s.path[l];
    store(z, l, p, out_);
    out_.t[p] = t;
    out_.status[p] = status;
    out_.steps[p] = s.steps[l];
    out_.condition[p] = out_.curvature[p] = out_.residual[p] = out_.correction[p] = -1.0;
    --under_way_;
    load(l);
  }

  // Two steps of Newton's method at s.next: their lengths, and that of what rounding causes.
  INLINE void correct(C* z, V& n1, V& n2, V& noise) {
    C first[N], second[N];
    linearize(H, w, z, s.next);
    factorize(w);
    solve(w, w.f, first);
    for (int i = 0; i < N; ++i) z[i] = z[i] - first[i];
    linearize(H, w, z, s.next);
    factorize(w);
    solve(w, w.f, second);
    for (int i = 0; i < N; ++i) z[i] = z[i] - second[i];
    normalize(z);
    n1 = norm(first), n2 = norm(second);
    noise = rounding(w);
  }

  // Which lanes accept the step.
  INLINE Mask judge(const V& n1, const V& n2, const V& noise) const {
    Mask accepted = (n1 <= kSlack * options_.predictor_tolerance) &
                    ((n2 <= options_.contraction * n1) |
                     ((n2 <= kNoise * noise) & (n2 <= kLongestNoise)));
    for (int l = 0; l < W; ++l)
      if (s.path[l] < 0) accepted[l] = 0;
    return accepted;
  }

  // The series at z, kept in the lanes that accepted the step; returns its radius of convergence.
  INLINE V renew(const C* z, const Mask& accepted) {
    C series[kOrder + 1][N];
    for (int i = 0; i < N; ++i) series[0][i] = z[i];
    expand(H, w, s.next, series);
    for (int k = 0; k <= kOrder; ++k)
      for (int i = 0; i < N; ++i) s.series[k][i] = select(accepted, series[k][i], s.series[k][i]);
    const V a0 = norm(series[kOrder]) + kTiny, a1 = norm(series[kOrder - 1]) + kTiny,
            a2 = norm(series[kOrder - 2]) + kTiny;
    C pole{};
    for (int i = 0; i < N; ++i)
      add_conjugate_product(pole, series[kOrder - 1][i], series[kOrder][i]);
    pole = (1.0 / (a1 * a1 + kTiny * kTiny)) * pole;
    s.pole = select(accepted, pole, s.pole);
    const V radius = minimum(a1 / a0, root(a2 / a0));
    leading_ = a0 / radius;
    return radius;
  }

  // What the corrections tell of the prediction and of the curvature.
  INLINE void learn(const V& step, const V& n1, const V& n2, const V& noise,
                    const Mask& accepted) {
    const V step2 = step * step, step4 = step2 * step2;
    const V power = step4 * step4;
    const V measured = n1 / (s.leading * power + kTiny * kTiny * kTiny);
    V surplus = maximum(measured, kSurplusMemory * s.surplus);
    surplus = minimum(maximum(surplus, splat(kLeastSurplus)), splat(kMostSurplus));
    surplus = select(step > 0.0, surplus, splat(1.0));
    s.surplus = select(accepted, surplus, s.surplus);
    s.leading = select(accepted, leading_, s.leading);
    const V curved = select(n2 > kNoise * noise, 2.0 * n2 / (n1 * n1), splat(0.0));
    s.bend = select(accepted, maximum(curved, kBendMemory * s.bend), s.bend);
  }

  // Sets s.t and s.next for the next step; returns its length.
  INLINE V advance(const V& step, const V& radius, const Mask& accepted) {
    const double waypoint = 1.0 - options_.waypoint;
    const V aim = minimum(splat(options_.predictor_tolerance),
                          kContraction * options_.contraction / (s.bend + kTiny));
    V onward =
        minimum(order_root(aim / (s.surplus * s.leading)), options_.radius_fraction * radius);
    const V here = select(accepted, s.next, s.t);
    V length = select(accepted, onward, kRetry * step);
    V next = here + length;
    next = select(next >= 1.0, splat(1.0), next);
    const Mask over = accepted & (here < waypoint) & (next > waypoint) & (next < 1.0);
    next = select(over, splat(waypoint), next);
    s.t = here;
    s.next = next;
    return next - here;
  }

  // Counts the step in each lane, and ends the paths that have arrived or cannot go on.
  INLINE void settle(const C* z, const V& arrived, const V& ahead, const Mask& accepted) {
    const double waypoint = 1.0 - options_.waypoint;
    const double nearest = 1.0 - options_.nearest;
    for (int l = 0; l < W; ++l) {
      if (s.path[l] < 0) continue;
      ++s.steps[l];
      if (accepted[l]) {
        if (lane(arrived, l) == 1.0) {
          finish(l, kRegular, z, 1.0);
          continue;
        }
        if (lane(arrived, l) == waypoint) {
          s.passed[l] = -1;
          for (int i = 0; i < N; ++i) put(s.waypoint[i], l, lane(z[i], l));
        }
      }
      const bool stuck =
          !(lane(ahead, l) > options_.min_step) || s.steps[l] >= options_.max_steps;
      if (s.passed[l] && (stuck || (lane(s.t, l) > nearest && lane(s.next, l) < 1.0)))
        finish(l, kSingular, s.waypoint, waypoint);
      else if (stuck)
        finish(l, kFailed, s.series[0], lane(s.t, l));
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

  const Homotopy& H;
  const Options& options_;
  const int paths_;
  const Complex* const points_;
  const Results& out_;
  int upcoming_ = 0, under_way_ = 0;
  alignas(64) Workspace w;
  alignas(64) Lanes s;
  V leading_;
};

}  // namespace

void GSP_TRACK(const Homotopy& homotopy, const Options& options, int paths, const Complex* points,
               const Results& results) {
  Tracker(homotopy, options, paths, points, results).run();
}

}  // namespace gsp
