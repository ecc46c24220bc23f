// Tracking of the paths of shifts.hpp, one in each lane; included by shifts.cpp in each of its builds.
#pragma once

#include "shifts_system.hpp"
#include "steps.hpp"

namespace gsp {
namespace {

// Corrections as long as this are rounding.
constexpr double kRounding = 1e-12;

template <int M, bool has_h, class Moving>
class ShiftTracker {
  static constexpr int D = 4 + M, kOrder = Moving::kOrder;

 public:
  ShiftTracker(const ShiftGeometry& geometry, const ShiftOptions& options, const ShiftPaths& paths,
             int begin, int end, const ShiftEnds& ends)
      : options_(options), paths_(paths), ends_(ends), upcoming_(begin * paths.paths),
        first_(begin * paths.paths), last_(end * paths.paths), w(geometry, paths) {}

  void run() {
    for (int k = 0; k <= kOrder; ++k)
      for (int i = 0; i < D; ++i) series_[k][i] = C{};
    for (int l = 0; l < W; ++l) load(l);
    while (under_way_ > 0) step();
    for (int p = first_; p < last_; p += W) refine(p);
  }

 private:
  void load(int l) {
    path_[l] = upcoming_ < last_ ? upcoming_++ : -1;
    steps_[l] = 0;
    s.begin(l);
    if (path_[l] < 0) return;
    ++under_way_;
    const int target = path_[l] / paths_.paths, start = paths_.start[target];
    const Complex* point = paths_.starts + (start * paths_.paths + path_[l] % paths_.paths) * D;
    for (int i = 0; i < D; ++i) {
      put(series_[0][i], l, point[i]);
      for (int k = 1; k <= kOrder; ++k) put(series_[k][i], l, {0.0, 0.0});
    }
    w.moving.load(l, target);
  }

  void finish(int l, Status status) {
    const int p = path_[l];
    for (int i = 0; i < D; ++i) ends_.point[p * D + i] = lane(w.x[i], l);
    ends_.status[p] = status;
    ends_.steps[p] = steps_[l];
    --under_way_;
    load(l);
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

  void step() {
    C z[D], first[D], second[D];
    predict(z);
    w.moving.go(s.next);
    V weight = splat(1.0);
    for (int i = 4; i < D; ++i) weight += square(z[i]);
    weight = 1.0 / weight;
    w.linearize(z);
    w.factorize();
    w.solve(w.f, first);
    for (int i = 0; i < D; ++i) z[i] = z[i] - first[i];
    w.linearize(z);
    w.factorize();
    w.solve(w.f, second);
    const V n1 = length(first, weight), n2 = length(second, weight), noise = splat(kRounding);
    Mask accepted = s.judge(aims(), n1, n2, noise);
    for (int l = 0; l < W; ++l)
      if (path_[l] < 0) accepted[l] = 0;
    // What the second correction changes in the factors is of second order.
    for (int i = 0; i < D; ++i) w.x[i] = w.x[i] - second[i];
    renew(weight, accepted);
    s.learn(n1, n2, noise, accepted);
    const V arrived = s.next;
    s.advance(aims(), accepted);
    settle(arrived, accepted);
  }

  Aims aims() const {
    return {options_.predictor_tolerance, options_.contraction, options_.radius_fraction};
  }

  // The series, kept in the lanes that accepted the step.
  INLINE void renew(const V& weight, const Mask& accepted) {
    C series[kOrder + 1][D];
    w.expand(series);
    for (int k = 0; k <= kOrder; ++k)
      for (int i = 0; i < D; ++i) series_[k][i] = select(accepted, series[k][i], series_[k][i]);
    const C *last = series[kOrder], *second = series[kOrder - 1];
    C product{}, scalars{};
    for (int i = 0; i < 4; ++i) add_conjugate_product(product, second[i], last[i]);
    for (int i = 4; i < D; ++i) add_conjugate_product(scalars, second[i], last[i]);
    s.expand({length(last, weight), length(second, weight), length(series[kOrder - 2], weight),
              product + weight * scalars},
             accepted);
  }

  INLINE void settle(const V& arrived, const Mask& accepted) {
    const V ahead = s.next - s.t;
    for (int l = 0; l < W; ++l) {
      if (path_[l] < 0) continue;
      ++steps_[l];
      if (accepted[l] && lane(arrived, l) == 1.0)
        finish(l, kRegular);
      else if (!(lane(ahead, l) > options_.min_step) || steps_[l] >= options_.max_steps)
        finish(l, kFailed);
    }
  }

  // A last step of Newton's method, and the Study points, of as many ends as there are lanes.
  void refine(int begin) {
    C z[D], change[D], study[N];
    for (int l = 0; l < W; ++l) {
      const int p = begin + l < last_ ? begin + l : last_ - 1;
      for (int i = 0; i < D; ++i) put(z[i], l, ends_.point[p * D + i]);
      w.moving.arrive(l, p / paths_.paths);
    }
    w.linearize(z);
    w.factorize();
    w.solve(w.f, change);
    for (int i = 0; i < D; ++i) z[i] = z[i] - change[i];
    normalize(z);
    w.measure(z);
    to_study(w, study);
    for (int l = 0; l < W && begin + l < last_; ++l) {
      for (int i = 0; i < D; ++i) ends_.point[(begin + l) * D + i] = lane(z[i], l);
      for (int i = 0; i < N; ++i) ends_.study[(begin + l) * N + i] = lane(study[i], l);
    }
  }

  const ShiftOptions& options_;
  const ShiftPaths& paths_;
  const ShiftEnds& ends_;
  int upcoming_;
  const int first_, last_;
  int under_way_ = 0;
  alignas(64) System<M, has_h, Moving> w;
  Steps<kOrder> s;
  C series_[kOrder + 1][D];
  int path_[W];
  std::int32_t steps_[W];
};

}  // namespace
}  // namespace gsp
