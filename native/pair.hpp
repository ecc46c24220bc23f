// Numbers of 32 digits, one at a time: the unevaluated sum of two doubles.
//
// Sums and products of T. J. Dekker (1971): nothing here may be reassociated or contracted.
#pragma once

namespace gsp {
namespace {

struct Pair {
  double hi, lo;
};

inline Pair sum(const Pair& a, const Pair& b) {
  const double s = a.hi + b.hi, v = s - a.hi;
  const double e = (a.hi - (s - v)) + (b.hi - v) + (a.lo + b.lo);
  const double hi = s + e;
  return {hi, e - (hi - s)};
}

inline Pair product(const Pair& a, const Pair& b) {
  const double p = a.hi * b.hi;
  const double e = __builtin_fma(a.hi, b.hi, -p) + (a.hi * b.lo + a.lo * b.hi);
  const double hi = p + e;
  return {hi, e - (hi - p)};
}

}  // namespace
}  // namespace gsp
