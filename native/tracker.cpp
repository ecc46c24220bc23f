// Adaptive tracking of several paths at a time, one in each lane of a vector.
//
// A step evaluates the Taylor series of every lane at its own step length. The last term is summed
// as a geometric series (a Pade approximant with the common pole). Then Newton's method corrects
// the point twice. In lanes whose corrections contract enough, the next Taylor series is computed
// with the second factorization. (With the first factorization the series would have a relative
// error proportional to the first correction, and steps would be short wherever paths bend.)
#include <algorithm>

#include "path_series.hpp"
#include "steps.hpp"

namespace gsp {
namespace {

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
    C product{};
    for (int i = 0; i < N; ++i)
      add_conjugate_product(product, series[kOrder - 1][i], series[kOrder][i]);
    s.expand({norm(series[kOrder]), norm(series[kOrder - 1]), norm(series[kOrder - 2]),
              product},
             accepted);
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
