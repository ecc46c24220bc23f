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

#if GSP_PARTS == 2
// Mixed operators for numbers of several doubles, from the other operators; T(d) converts a vector of doubles.
template <class T>
concept Extended = requires { T::kParts; };

template <Extended T>
INLINE T operator-(const T& a, const T& b) { return a + -b; }
template <Extended T>
INLINE T operator*(double a, const T& b) { return (D{} + a) * b; }
template <Extended T>
INLINE T operator*(const T& a, double b) { return (D{} + b) * a; }
template <Extended T>
INLINE T operator/(double a, const T& b) { return T(D{} + a) / b; }
template <Extended T>
INLINE T operator-(double a, const T& b) { return T(D{} + a) - b; }
template <Extended T>
INLINE T operator+(double a, const T& b) { return T(D{} + a) + b; }
template <Extended T>
INLINE T operator+(const T& a, double b) { return a + T(D{} + b); }
template <Extended T>
INLINE void operator+=(T& a, const T& b) { a = a + b; }
template <Extended T>
INLINE void operator-=(T& a, const T& b) { a = a - b; }

template <Extended T>
INLINE Mask operator>(const T& a, const T& b) { return b < a; }
template <Extended T>
INLINE Mask operator>=(const T& a, const T& b) { return b <= a; }
template <Extended T>
INLINE Mask operator<(const T& a, double b) { return a < T(D{} + b); }
template <Extended T>
INLINE Mask operator<=(const T& a, double b) { return a <= T(D{} + b); }
template <Extended T>
INLINE Mask operator>(const T& a, double b) { return T(D{} + b) < a; }
template <Extended T>
INLINE Mask operator>=(const T& a, double b) { return T(D{} + b) <= a; }

// Vectors of double-double numbers: an unevaluated sum hi + lo of two doubles has 32 digits.
//
// Sums and products by the error-free transformations of T. J. Dekker (A floating-point technique
// for extending the available precision, 1971) and D. E. Knuth, as in Y. Hida, X. S. Li, D. H.
// Bailey (Library for double-double and quad-double arithmetic, 2007). Nothing here may be
// reassociated, and a product may be contracted only where it is written as a fused one.
struct DoubleDouble {
  static constexpr int kParts = 2;
  D hi, lo;
  DoubleDouble() = default;
  explicit INLINE DoubleDouble(const D& x) : hi(x), lo{} {}
  INLINE DoubleDouble(const D& a, const D& b) : hi(a), lo(b) {}
  // Vector by vector, as C in lanes.hpp.
  INLINE DoubleDouble(const DoubleDouble& o) : hi(o.hi), lo(o.lo) {}
  INLINE DoubleDouble& operator=(const DoubleDouble& o) {
    hi = o.hi, lo = o.lo;
    return *this;
  }
};

// hi + lo, if |a| >= |b|.
INLINE DoubleDouble quick_sum(const D& a, const D& b) {
  const D s = a + b;
  return {s, b - (s - a)};
}

// a + b without error.
INLINE DoubleDouble exact_sum(const D& a, const D& b) {
  const D s = a + b, v = s - a;
  return {s, (a - (s - v)) + (b - v)};
}

// a b without error.
INLINE DoubleDouble exact_product(const D& a, const D& b) {
  const D p = a * b;
#if defined(GSP_FUSED)
  return {p, fused(a, b, -p)};
#else
  // Without such an instruction by halves (Veltkamp, Dekker), for numbers below 2^996.
  const D x = 134217729.0 * a, y = 134217729.0 * b;
  const D high = x - (x - a), other = y - (y - b), low = a - high, rest = b - other;
  return {p, ((high * other - p) + high * rest + low * other) + low * rest};
#endif
}

INLINE DoubleDouble operator-(const DoubleDouble& a) { return {-a.hi, -a.lo}; }
INLINE DoubleDouble operator+(const DoubleDouble& a, const DoubleDouble& b) {
  const DoubleDouble s = exact_sum(a.hi, b.hi), t = exact_sum(a.lo, b.lo);
  const DoubleDouble u = quick_sum(s.hi, s.lo + t.hi);
  return quick_sum(u.hi, u.lo + t.lo);
}
INLINE DoubleDouble operator*(const DoubleDouble& a, const DoubleDouble& b) {
  const DoubleDouble p = exact_product(a.hi, b.hi);
  return quick_sum(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
}
INLINE DoubleDouble operator*(const D& a, const DoubleDouble& b) {
  const DoubleDouble p = exact_product(a, b.hi);
  return quick_sum(p.hi, p.lo + a * b.lo);
}
INLINE DoubleDouble operator/(const DoubleDouble& a, const DoubleDouble& b) {
  const D first = a.hi / b.hi;
  const DoubleDouble left = a - first * b;
  return quick_sum(first, left.hi / b.hi);
}

INLINE Mask operator<(const DoubleDouble& a, const DoubleDouble& b) {
  return (a.hi < b.hi) | ((a.hi == b.hi) & (a.lo < b.lo));
}
INLINE Mask operator<=(const DoubleDouble& a, const DoubleDouble& b) {
  return (a.hi < b.hi) | ((a.hi == b.hi) & (a.lo <= b.lo));
}

INLINE DoubleDouble select(const Mask& m, const DoubleDouble& a, const DoubleDouble& b) {
  return {m ? a.hi : b.hi, m ? a.lo : b.lo};
}

// The square root of numbers that are not negative.
INLINE DoubleDouble root(const DoubleDouble& x) {
  const D first = root(x.hi);
  const DoubleDouble left = x - exact_product(first, first);
  const D correction = first > 0.0 ? left.hi / (first + first) : first;
  return quick_sum(first, correction);
}

// Sets one of the two doubles in all lanes.
INLINE void put_part(DoubleDouble& x, int part, double value) { (part ? x.lo : x.hi) = D{} + value; }
INLINE double lane(const DoubleDouble& x, int l) { return x.hi[l]; }
INLINE double part_of(const DoubleDouble& x, int l, int part) { return (part ? x.lo : x.hi)[l]; }
INLINE void set_part(DoubleDouble& x, int l, int part, double value) {
  (part ? x.lo : x.hi)[l] = value;
}
INLINE void put(DoubleDouble& x, int l, double value) {
  x.hi[l] = value;
  x.lo[l] = 0.0;
}

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
