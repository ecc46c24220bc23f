// Numbers of 32 digits, one at a time: the unevaluated sum of two doubles.
//
// Sums and products of T. J. Dekker (1971): nothing here may be reassociated or contracted.
#pragma once

namespace gsp {
namespace {

struct Pair {
  double hi, lo;
};

// high + low, if |high| >= |low|.
inline Pair renormalized(double high, double low) {
  const double s = high + low;
  return {s, low - (s - high)};
}

inline Pair sum(const Pair& a, const Pair& b) {
  const double s = a.hi + b.hi, v = s - a.hi;
  return renormalized(s, (a.hi - (s - v)) + (b.hi - v) + (a.lo + b.lo));
}

inline Pair product(const Pair& a, const Pair& b) {
  const double p = a.hi * b.hi;
  return renormalized(p, __builtin_fma(a.hi, b.hi, -p) + (a.hi * b.lo + a.lo * b.hi));
}

}  // namespace
}  // namespace gsp
