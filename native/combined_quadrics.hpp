// Values and derivatives of equations from those of their quadrics, for numbers of any kind.
//
// Included by isolation.hpp and finer_points.cpp: all in an anonymous namespace, so that the linker cannot
// merge functions that were compiled for different processors.
#pragma once

#include "lanes.hpp"
#include "proofs.hpp"

namespace gsp {
namespace {

// Values and gradients of quadrics, of complex numbers or of bounds of moduli.
template <class T>
struct Quadrics {
  T value[kMostQuadrics];
  T gradient[kMostQuadrics][N];
};

INLINE void add_real(C& s, double a, const C& b) {
  s.re += a * b.re;
  s.im += a * b.im;
}
INLINE void add_real(D& s, double a, const D& b) { s += a * b; }
INLINE void add_term(C& s, const C& a, const C& b) { add_product(s, a, b); }
INLINE void add_term(D& s, const D& a, const D& b) { s += a * b; }
INLINE C half(const C& a) { return {0.5 * a.re, 0.5 * a.im}; }
INLINE D half(const D& a) { return 0.5 * a; }

// The rows of the equations and of their derivatives; the sign of the squares is -1, and 1 for
// bounds of moduli.
template <class T>
void combine(const ProofSystem& system, const Quadrics<T>& q, double sign, T* value,
             T (*jacobian)[N]) {
  value[0] = q.value[1];
  for (int i = 0; i < N; ++i) jacobian[0][i] = q.gradient[1][i];
  for (int r = 0; r < kEquations; ++r) {
    const ProofEquation& e = system.equation[r];
    T* const row = jacobian[r + 1];
    if (e.squares[0] < 0) {
      value[r + 1] = q.value[e.main];
      for (int i = 0; i < N; ++i) row[i] = q.gradient[e.main][i];
      continue;
    }
    T s{};
    add_term(s, q.value[0], q.value[e.main]);
    for (int i = 0; i < N; ++i) {
      row[i] = T{};
      add_term(row[i], q.value[e.main], q.gradient[0][i]);
      add_term(row[i], q.value[0], q.gradient[e.main][i]);
    }
    for (const int b : e.squares) {
      if (b < 0) break;
      T scaled{};
      add_real(scaled, sign, q.value[b]);
      add_term(s, scaled, q.value[b]);
      add_real(scaled, sign, q.value[b]);
      for (int i = 0; i < N; ++i) add_term(row[i], scaled, q.gradient[b][i]);
    }
    value[r + 1] = s;
  }
}

}  // namespace
}  // namespace gsp
