// How long the steps of path tracking are, for as many paths as there are lanes.
//
// The control is that of S. Telen, M. Van Barel, J. Verschelde (A robust numerical path tracking
// algorithm for polynomial homotopy continuation, SIAM J. Sci. Comput. 42, 2020) and S. Timme (Mixed
// precision path tracking for polynomial homotopy continuation, Adv. Comput. Math. 47, 2021): the
// last terms of the series tell its radius of convergence and its error.
//
// Included by each build of tracker.cpp and reduced_homotopy.cpp: all in an anonymous namespace, so that the
// linker cannot merge functions that were compiled for different processors.
#pragma once

#include "lanes.hpp"

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
// The measured curvature is halved from step to step unless it is measured again.
constexpr double kBendMemory = 0.5;
// The next correction is to contract by this part of what is allowed.
constexpr double kContraction = 0.4;
// A rejected step is tried again with this part of its length.
constexpr double kRetry = 0.5;
// The last term is summed as a geometric series unless |1 - step / pole|^2 is smaller: there the
// step would end near the pole, and only the distance of the pole is known well.
constexpr double kIntoPole = 0.09;
// Added to norms, so that the quotient of two zero norms is 1 where a path does not move.
constexpr double kTiny = 1e-100;

// The requirements of a step.
struct Aims {
  double predictor_tolerance, contraction, radius_fraction;
};

// The (order + 1)-th root of positive numbers: of the orders 3 and 7 exactly, of others to a percent,
// which is enough for the length of a step.
template <int order>
INLINE V order_root(const V& x) {
  if constexpr (order == 3) {
    return root(root(x));
  } else if constexpr (order == 7) {
    return root(root(root(x)));
  } else {
#if GSP_PARTS > 1
    static_assert(order == 7);
#else
    // The exponent and the fraction of a double are nearly its logarithm; then one step of Newton's.
    constexpr double kOne = 1023.0 * 0x1p52, kPart = 1.0 / (order + 1);
    const V logarithm = __builtin_convertvector((Mask)x, V);
    const Mask bits = __builtin_convertvector(kOne + kPart * (logarithm - kOne), Mask);
    const V y = (V)bits;
    V power = y;
    for (int i = 1; i < order; ++i) power = power * y;
    return y + kPart * (x / power - y);
#endif
  }
}

template <int order>
INLINE V step_power(const V& step) {
  V power = step;
  for (int i = 0; i < order; ++i) power = power * step;
  return power;
}

// Norms of the last three terms of a series, and the product of the last but one (conjugate) and
// the last.
struct Tail {
  V last, second, third;
  C product;
};

// The state of the steps in all lanes.
template <int order>
struct Steps {
  V t, next;  // where the series is expanded; where the step goes
  C pole;     // 1 / (common pole of the last two terms)
  V leading;  // the error of the prediction is about surplus * leading * step^(order + 1)
  V surplus;
  V bend;     // estimate of the norm of J^-1 D^2 F
  V radius;   // of convergence, of the last expansion

  // The first step has length zero: it corrects the start point and expands there.
  INLINE void begin(int l) {
    put(pole, l, {0.0, 0.0});
    V* const zero[] = {&t, &next, &leading, &bend};
    for (V* x : zero) put(*x, l, 0.0);
    put(surplus, l, 1.0);
  }

  // The first step has length zero, at 1 - left, with all digits.
  INLINE void start_before_end(int l, double left) {
    Mask chosen{};
    chosen[l] = -1;
    t = select(chosen, splat(1.0) - splat(left), t);
    next = select(chosen, t, next);
  }

  // What the last term of the series is multiplied by, to be summed as a geometric series.
  INLINE C top() const {
    const V step = next - t;
    const C d{1.0 - step * pole.re, -(step * pole.im)};
    const V size = square(d);
    const V scale = 1.0 / size;
    const Mask far = size > kIntoPole;
    return select(far, C{d.re * scale, -(d.im * scale)}, C{splat(1.0), splat(0.0)});
  }

  // Which steps are good by the lengths of two corrections and of what rounding causes.
  INLINE Mask judge(const Aims& aims, const V& n1, const V& n2, const V& noise) const {
    return (n1 <= kSlack * aims.predictor_tolerance) &
           ((n2 <= aims.contraction * n1) | ((n2 <= kNoise * noise) & (n2 <= kLongestNoise)));
  }

  // Takes pole, radius and leading term from a new series.
  INLINE void expand(const Tail& tail, const Mask& accepted) {
    const V a0 = tail.last + kTiny, a1 = tail.second + kTiny, a2 = tail.third + kTiny;
    pole = select(accepted, (1.0 / (a1 * a1 + kTiny * kTiny)) * tail.product, pole);
    radius = minimum(a1 / a0, root(a2 / a0));
    leading = select(accepted, a0 / radius, leading);
  }

  // Estimates the error of the prediction and the curvature from the corrections, before the next expansion.
  INLINE void learn(const V& n1, const V& n2, const V& noise, const Mask& accepted) {
    const V step = next - t;
    const V measured = n1 / (leading * step_power<order>(step) + kTiny * kTiny * kTiny);
    V worse = maximum(measured, kSurplusMemory * surplus);
    worse = minimum(maximum(worse, splat(kLeastSurplus)), splat(kMostSurplus));
    worse = select(step > 0.0, worse, splat(1.0));
    surplus = select(accepted, worse, surplus);
    const V curved = select(n2 > kNoise * noise, 2.0 * n2 / (n1 * n1), splat(0.0));
    bend = select(accepted, maximum(curved, kBendMemory * bend), bend);
  }

  // Moves to the end of an accepted step, and sets the end of the next one.
  INLINE void advance(const Aims& aims, const Mask& accepted) {
    const V step = next - t;
    const V aim = minimum(splat(aims.predictor_tolerance),
                          kContraction * aims.contraction / (bend + kTiny));
    const V onward =
        minimum(order_root<order>(aim / (surplus * leading)), aims.radius_fraction * radius);
    t = select(accepted, next, t);
    next = t + select(accepted, onward, kRetry * step);
    next = select(next >= 1.0, splat(1.0), next);
  }
};

}  // namespace
}  // namespace gsp
