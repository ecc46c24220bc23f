// Complex arithmetic on vectors of real numbers, one path in each lane: doubles, or with GSP_EXTENDED
// double-double numbers.
//
// Included by each build of tracker.cpp and of intersection.cpp: all in an anonymous namespace, so
// that the linker cannot merge functions that were compiled for different processors.
#pragma once

#include "tracker.hpp"

#if !defined(GSP_LANES)
#error "GSP_LANES must be the width of the vectors of this build"
#endif

namespace gsp {
namespace {

constexpr int W = GSP_LANES;
constexpr int N = kVariables;

typedef double D __attribute__((vector_size(8 * W)));
typedef long long Mask __attribute__((vector_size(8 * W)));

#define INLINE inline __attribute__((always_inline))

INLINE D root(const D& x) {
  D r;
  for (int i = 0; i < W; ++i) r[i] = __builtin_sqrt(x[i]);
  return r;
}

}  // namespace
}  // namespace gsp

#if defined(GSP_EXTENDED)
#include "extended.hpp"
#endif

namespace gsp {
namespace {

#if defined(GSP_EXTENDED)
typedef Extended V;
constexpr double kEpsilon = 1e-31;  // of rounding in the equations
#else
typedef D V;
constexpr double kEpsilon = 4e-16;
INLINE V splat(double x) { return V{} + x; }
INLINE V select(const Mask& m, const V& a, const V& b) { return m ? a : b; }
INLINE double lane(const V& x, int l) { return x[l]; }
INLINE double low_lane(const V&, int) { return 0.0; }
INLINE void put(V& x, int l, double value) { x[l] = value; }
#endif

struct C {
  V re, im;
};

INLINE Complex lane(const C& x, int l) { return {lane(x.re, l), lane(x.im, l)}; }
INLINE Complex low_lane(const C& x, int l) { return {low_lane(x.re, l), low_lane(x.im, l)}; }
INLINE void put(C& x, int l, const Complex& value) {
  put(x.re, l, value.re);
  put(x.im, l, value.im);
}

INLINE C operator+(const C& a, const C& b) { return {a.re + b.re, a.im + b.im}; }
INLINE C operator-(const C& a, const C& b) { return {a.re - b.re, a.im - b.im}; }
INLINE C operator*(const C& a, const C& b) {
  return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}
INLINE C operator*(const V& a, const C& b) { return {a * b.re, a * b.im}; }
INLINE C operator*(const Complex& a, const C& b) {
  return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}
INLINE void add_product(C& s, const C& a, const C& b) {
  s.re += a.re * b.re;
  s.re -= a.im * b.im;
  s.im += a.re * b.im;
  s.im += a.im * b.re;
}
INLINE void add_product(C& s, const Complex& a, const C& b) {
  s.re += a.re * b.re;
  s.re -= a.im * b.im;
  s.im += a.re * b.im;
  s.im += a.im * b.re;
}
INLINE void subtract_product(C& s, const C& a, const C& b) {
  s.re -= a.re * b.re;
  s.re += a.im * b.im;
  s.im -= a.re * b.im;
  s.im -= a.im * b.re;
}
// s += conj(a) b
INLINE void add_conjugate_product(C& s, const C& a, const C& b) {
  s.re += a.re * b.re;
  s.re += a.im * b.im;
  s.im += a.re * b.im;
  s.im -= a.im * b.re;
}
INLINE V square(const C& a) { return a.re * a.re + a.im * a.im; }
INLINE V minimum(const V& a, const V& b) { return select(a < b, a, b); }
INLINE V maximum(const V& a, const V& b) { return select(a > b, a, b); }
INLINE C select(const Mask& m, const C& a, const C& b) {
  return {select(m, a.re, b.re), select(m, a.im, b.im)};
}
INLINE C line(const Complex& start, const Complex& change, const V& t) {
  return {start.re + t * change.re, start.im + t * change.im};
}
INLINE V norm(const C* x) {
  V s = square(x[0]);
  for (int i = 1; i < N; ++i) s += square(x[i]);
  return root(s);
}

}  // namespace
}  // namespace gsp
