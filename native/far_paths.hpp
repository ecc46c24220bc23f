// Paths of poses far away in their local coordinates, in lanes: along a line between two shifts of the values.
//
// Two such poses may be near each other, and come together where values change. From complex values in general
// position no two do on the way to real ones.
//
// Included by far_poses.cpp in each of its builds: all in an anonymous namespace, so that the linker
// cannot merge functions that were compiled for different processors.
#pragma once

#include "far_equations.hpp"

namespace gsp {
namespace {

constexpr double kFirstStep = 0.125, kLeastStep = 0x1p-14;
// The second step of Newton's method after a prediction is at most such a part of the first: then the other
// solutions are many times as far away as the prediction is off. After a much smaller one steps grow.
constexpr double kCertainly = 1.0 / 16, kEasily = 1.0 / 512;
// Of values in doubles, as a part of the moduli of their terms. Where a step may be longer than such a part of the
// coordinates (or of kLeastSize, if they are smaller), digits are lost, and nothing is found.
constexpr double kNoise = 0x1p-48, kLostDigits = 1e-4, kLeastSize = 1e-3;

struct Tangent {
  C at[kRows], along[kRows];
};

INLINE V largest(const C* x) {
  V most = splat(0.0);
  for (int i = 0; i < kRows; ++i) most = maximum(most, bound(x[i]));
  return most;
}

INLINE bool any(const Mask& m) {
  for (int l = 0; l < W; ++l)
    if (m[l]) return true;
  return false;
}

// How long a step of Newton's method may be because of rounding.
INLINE V noise(const Block& b, const C* shift, const C* s, const Linear& at) {
  V size[kRows], terms[kRows], most = splat(0.0);
  for (int i = 0; i < kRows; ++i) size[i] = bound(s[i]);
  const V norm = sizes_of(b, kOfNorm * kLocalMonomials, size).value;
  for (int r = 0; r < kRows; ++r) {
    terms[r] = sizes_of(b, r * kLocalMonomials, size).value;
    V by = bound(shift[r]) * norm;
    if (b.second[r]) {
      terms[r] *= sizes_of(b, b.second[r], size).value;
      by = (by + bound(b.number(b.second[r] + kConstant)) * norm) * norm;
    }
    terms[r] += by;
  }
  for (int i = 0; i < kRows; ++i) {
    V sum = splat(0.0);
    for (int r = 0; r < kRows; ++r) sum += bound(at.inverse[i][r]) * terms[r];
    most = maximum(most, sum);
  }
  return splat(kNoise) * most;
}

// How local coordinates change with a shift, from the equations there and N.
INLINE void differentiate_by_shift(const Block& b, const Linear& at, const C& norm, const C* change, C* along) {
  C by[kRows];
  for (int r = 0; r < kRows; ++r) by[r] = b.second[r] ? norm * change[r] : change[r];
  for (int i = 0; i < kRows; ++i) {
    along[i] = C{};
    for (int r = 0; r < kRows; ++r) add_product(along[i], by[r], at.inverse[i][r]);
    along[i] = norm * along[i];
  }
}

// Follows local coordinates in all lanes between two shifts of the equations, with steps of their own. In lanes where
// steps become too small the coordinates are not changed; returns the others.
Mask follow_line(const Block& b, const C* from, const C* to, C* s) {
  C change[kRows], here[kRows];
  for (int r = 0; r < kRows; ++r) change[r] = to[r] - from[r];
  Linear at;
  Tangent now, last;
  C norm = linearize(b, from, s, at), first[kRows], second[kRows];
  differentiate_by_shift(b, at, norm, change, now.along);
  for (int i = 0; i < kRows; ++i) now.at[i] = s[i];
  last = now;
  V done = splat(0.0), step = splat(kFirstStep), before = splat(0.0);
  Mask active = done < 1.0;
  while (true) {
    // A last step that is hardly shorter goes to the end.
    step = select(done + 1.125 * step > 1.0, 1.0 - done, step);
    active &= (done < 1.0) & (step >= kLeastStep);
    if (!any(active)) break;
    const V t = done + step;
    for (int r = 0; r < kRows; ++r) here[r] = select(t >= 1.0, to[r], from[r] + t * change[r]);
    // By the cubic through the last two points with their tangents, else by the tangent.
    C guess[kRows];
    const V q = select(before > 0.0, step / before, splat(0.0));
    for (int i = 0; i < kRows; ++i) {
      const C gap = now.at[i] - last.at[i];
      const C bend = before * (splat(2.0) * now.along[i] + last.along[i]) - splat(3.0) * gap;
      const C twist = before * (now.along[i] + last.along[i]) - splat(2.0) * gap;
      guess[i] = now.at[i] + step * now.along[i] + (q * q) * (bend + q * twist);
    }
    linearize(b, here, guess, at);
    newton_step(at, first);
    for (int i = 0; i < kRows; ++i) guess[i] = guess[i] - first[i];
    norm = linearize(b, here, guess, at);
    newton_step(at, second);
    for (int i = 0; i < kRows; ++i) guess[i] = guess[i] - second[i];
    const V one = largest(first), two = largest(second);
    // A comparison with NaN is false.
    Mask good = two <= kCertainly * one, easy = two <= kEasily * one;
    if (any(active & ~easy)) {
      const V least = noise(b, here, guess, at);
      const Mask exact = (one + two <= least) & (least <= kLostDigits * maximum(largest(guess), splat(kLeastSize)));
      good |= exact, easy |= exact;
    }
    good &= active;
    C along[kRows];
    differentiate_by_shift(b, at, norm, change, along);
    for (int i = 0; i < kRows; ++i) {
      last.at[i] = select(good, now.at[i], last.at[i]), last.along[i] = select(good, now.along[i], last.along[i]);
      now.at[i] = select(good, guess[i], now.at[i]), now.along[i] = select(good, along[i], now.along[i]);
    }
    before = select(good, step, before), done = select(good, t, done);
    step = select(good, select(easy, 2.0 * step, step), 0.5 * step);
  }
  const Mask arrived = done >= 1.0;
  for (int i = 0; i < kRows; ++i) s[i] = select(arrived, now.at[i], s[i]);
  return arrived;
}

}  // namespace
}  // namespace gsp
