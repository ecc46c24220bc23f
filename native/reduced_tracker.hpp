// Tracking of the paths of reduced_homotopy.hpp, one in each lane; included by reduced_homotopy.cpp in each of its builds.
#pragma once

#include "reduced_system.hpp"
#include "steps.hpp"

namespace gsp {
namespace {

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
}  // namespace gsp
