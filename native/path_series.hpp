// The Taylor series of paths, from the factors of the Jacobian matrix at their start.
//
// Included by tracker.cpp in each of its builds: all in an anonymous namespace, so that the linker
// cannot merge functions that were compiled for different processors.
#pragma once

#include "newton.hpp"

namespace gsp {
namespace {

// Of order k in the product of two series.
INLINE C coefficient(const C* a, const C* b, int k) {
  C s{};
  if (a == b) {
    for (int j = 0; 2 * j < k; ++j) add_product(s, a[j], a[k - j]);
    s = s + s;
    if (k % 2 == 0) add_product(s, a[k / 2], a[k / 2]);
    return s;
  }
  for (int j = 0; j <= k; ++j) add_product(s, a[j], b[k - j]);
  return s;
}

// The Taylor series of the paths through series[0] at t, with the factorization that linearize()
// and factorize() have left.
void expand(const Equations& H, Workspace& w, const V& t, C (*series)[N]) {
  Pairs pairs;
  C phi[kFeatures], before[kFeatures], mixed[kFeatures], b[kRows];
  take_square<true>(pairs, series[0]);
  features(pairs, before);
  bool any_product = kReal;
  for (int i = 0; i < kEquations; ++i) any_product |= H.product[i];
  C square_before = w.n[0] * w.n[0];  // the coefficient of N^2 before
  for (int k = 1; k <= kOrder; ++k) {
    const bool bent = k > 1;  // with terms that are not linear
    b[0] = C{};
    if (bent) {
      take_between(pairs, series, k);
      features(pairs, phi);
      for (int i = 0; i < kFeatures; ++i) {
        mixed[i].re = t * phi[i].re + before[i].re;
        mixed[i].im = t * phi[i].im + before[i].im;
      }
      for (int i = 0; i < 4; ++i) b[0] = b[0] - pairs.ef[i][i];
    }
    const auto given = [&](const Line& q) {
      return bent ? value(q, phi, mixed) : change(q, before);
    };
    C square_now{};
    if (any_product) {
      w.n[k] = bent ? norm_form(pairs.ee) : C{};
      square_now = coefficient(w.n, w.n, k);
    }
    for (int i = 0; i < kEquations; ++i) {
      C g = given(H.quadric[i]);
      if (!H.product[i]) {
        if constexpr (kReal) {
          add_times_i(g, w.value[i], w.n[k]);
          add_times_i(g, value_change(H, i), w.n[k - 1]);
        }
        b[i + 1] = C{} - g;
        continue;
      }
      w.g[i][k] = g;
      w.h[i][k] = given(H.quadric[i + kEquations]);
      const C s = kReal ? coefficient(w.g[i], w.g[i], k) + coefficient(w.h[i], w.h[i], k)
                        : coefficient(w.g[i], w.h[i], k);
      b[i + 1] = w.tau[i] * square_now - s;
      add_product(b[i + 1], tau_change(H, i), square_before);
    }
    C* x = series[k];
    solve(w, b, x);
    if (k == kOrder) break;
    // Complete the terms of order k by those that are linear in x.
    for (int i = 0; i < kEquations; ++i) {
      if (!H.product[i]) continue;
      for (int j = 0; j < N; ++j) {
        add_product(w.g[i][k], w.factor[i][j], x[j]);
        add_product(w.h[i][k], w.factor[i + kEquations][j], x[j]);
      }
    }
    if (bent)
      take_both<false>(pairs, series[0], x);
    else
      take_both<true>(pairs, series[0], x);
    if (any_product) {
      w.n[k] = norm_form(pairs.ee);
      square_before = coefficient(w.n, w.n, k);
    }
    features(pairs, before);
  }
}

}  // namespace
}  // namespace gsp
