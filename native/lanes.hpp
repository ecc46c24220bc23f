// Complex arithmetic on vectors of real numbers, one path in each lane: sums of GSP_PARTS doubles,
// one or two.
//
// Included by each build of tracker.cpp and of intersection.cpp: all in an anonymous namespace, so
// that the linker cannot merge functions that were compiled for different processors.
#pragma once

#include "tracker.hpp"

#if defined(__FMA__)
#include <immintrin.h>
#endif

#if !defined(GSP_LANES)
#error "GSP_LANES must be the width of the vectors of this build"
#endif
#if !defined(GSP_PARTS)
#define GSP_PARTS 1
#endif

namespace gsp {
namespace {

constexpr int W = GSP_LANES;
constexpr int N = kVariables;

typedef double D __attribute__((vector_size(8 * W)));
typedef long long Mask __attribute__((vector_size(8 * W)));

#define INLINE inline __attribute__((always_inline))
#define NOINLINE __attribute__((noinline, unused))

INLINE D root(const D& x) {
  D r;
  for (int i = 0; i < W; ++i) r[i] = __builtin_sqrt(x[i]);
  return r;
}

#if defined(__FMA__) || defined(__aarch64__)
#define GSP_FUSED
// a b + c, rounded once. Compilers take loops over such products apart: they are written as what they are.
INLINE D fused(const D& a, const D& b, const D& c) {
#if defined(__AVX512F__) && GSP_LANES == 8
  return (D)_mm512_fmadd_pd((__m512d)a, (__m512d)b, (__m512d)c);
#elif defined(__FMA__) && GSP_LANES == 4
  return (D)_mm256_fmadd_pd((__m256d)a, (__m256d)b, (__m256d)c);
#else
  D r;
  for (int l = 0; l < W; ++l) r[l] = __builtin_fma(a[l], b[l], c[l]);
  return r;
#endif
}
#endif

}  // namespace
}  // namespace gsp

#if GSP_PARTS == 2
#include "double_double.hpp"
#endif

namespace gsp {
namespace {

#if GSP_PARTS == 2
typedef DoubleDouble V;
constexpr double kEpsilon = 1e-31;  // of rounding in the equations
INLINE V splat(double x) { return V(D{} + x); }
#else
typedef D V;
constexpr double kEpsilon = 4e-16;
INLINE V splat(double x) { return V{} + x; }
INLINE V select(const Mask& m, const V& a, const V& b) { return m ? a : b; }
INLINE double lane(const V& x, int l) { return x[l]; }
INLINE void put(V& x, int l, double value) { x[l] = value; }
#endif

struct C {
  V re, im;
  C() = default;
  INLINE C(const V& a, const V& b) : re(a), im(b) {}
  // Vector by vector: compilers copy plain structures by 16 bytes, and a processor that loads a whole
  // vector of what was stored in pieces waits until they have left its store buffer.
  INLINE C(const C& o) : re(o.re), im(o.im) {}
  INLINE C& operator=(const C& o) {
    re = o.re, im = o.im;
    return *this;
  }
};

INLINE Complex lane(const C& x, int l) { return {lane(x.re, l), lane(x.im, l)}; }
INLINE void put(C& x, int l, const Complex& value) {
  put(x.re, l, value.re);
  put(x.im, l, value.im);
}

#if GSP_PARTS > 1
// The same number into all lanes, as the first part or another one.
INLINE void put(C& x, const Complex& value, int part = 0) {
  put_part(x.re, part, value.re);
  put_part(x.im, part, value.im);
}
#endif

INLINE C operator+(const C& a, const C& b) { return {a.re + b.re, a.im + b.im}; }
INLINE C operator-(const C& a, const C& b) { return {a.re - b.re, a.im - b.im}; }
INLINE C operator*(const C& a, const C& b) {
  return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}
INLINE C operator*(const V& a, const C& b) { return {a * b.re, a * b.im}; }
// a b for doubles a.
INLINE C by(const D& a, const C& b) { return {a * b.re, a * b.im}; }
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
INLINE void add_product(C& s, const V& a, const C& b) {
  s.re += a * b.re;
  s.im += a * b.im;
}
INLINE void subtract_product(C& s, const V& a, const C& b) {
  s.re -= a * b.re;
  s.im -= a * b.im;
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
// A sum of products, its four parts apart lest each waits for the one before.
struct Sum {
  V same_re, same_im, mixed, mixed_too;
  INLINE void add(const C& a, const C& b) {
    same_re += a.re * b.re;
    same_im += a.im * b.im;
    mixed += a.re * b.im;
    mixed_too += a.im * b.re;
  }
  // Of a b, and of conj(a) b.
  INLINE C total() const { return {same_re - same_im, mixed + mixed_too}; }
  INLINE C conjugate_total() const { return {same_re + same_im, mixed - mixed_too}; }
};
INLINE V square(const C& a) { return a.re * a.re + a.im * a.im; }
INLINE V minimum(const V& a, const V& b) { return select(a < b, a, b); }
INLINE V maximum(const V& a, const V& b) { return select(a > b, a, b); }
INLINE C select(const Mask& m, const C& a, const C& b) {
  return {select(m, a.re, b.re), select(m, a.im, b.im)};
}
// How a coefficient changes along the path, in as many digits as there are: `more` has what doubles
// cannot tell.
template <int n>
INLINE auto change_of(const Complex (&change)[n], [[maybe_unused]] const Complex (&more)[kMore][n],
                      int i) {
#if GSP_PARTS == 1
  return change[i];
#else
  C sum;
  put(sum, change[i]);
  for (int k = 0; k + 1 < GSP_PARTS; ++k) put(sum, more[k][i], k + 1);
  return sum;
#endif
}
// The coefficient at t.
template <int n>
INLINE C line(const Complex (&start)[n], const Complex (&change)[n], const Complex (&more)[kMore][n],
              int i, const V& t) {
  const auto by = change_of(change, more, i);
  return {start[i].re + t * by.re, start[i].im + t * by.im};
}
INLINE V norm(const C* x) {
  V s = square(x[0]);
  for (int i = 1; i < N; ++i) s += square(x[i]);
  return root(s);
}

}  // namespace
}  // namespace gsp
