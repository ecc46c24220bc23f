// J = L R by modified Gram-Schmidt: the rows of R are orthogonal, L has ones on its diagonal.
//
// It needs no pivoting, and so no branches between lanes; least-norm solutions of J x = b are
// R^H (R R^H)^-1 L^-1 b.
#pragma once

#include "lanes.hpp"

namespace gsp {
namespace {

// The rows of J become those of R; `inverse` is of the squares of their lengths.
template <int rows, int columns>
INLINE void factorize(C (*__restrict row)[columns], C (*__restrict lower)[rows],
                      V* __restrict inverse) {
  for (int j = 0; j < rows; ++j) {
    const C* r = row[j];
    V size = square(r[0]);
    for (int k = 1; k < columns; ++k) size += square(r[k]);
    inverse[j] = 1.0 / size;
    for (int i = j + 1; i < rows; ++i) {
      Sum sum{};
      for (int k = 0; k < columns; ++k) sum.add(r[k], row[i][k]);
      const C s = inverse[j] * sum.conjugate_total();
      for (int k = 0; k < columns; ++k) subtract_product(row[i][k], s, r[k]);
      lower[i][j] = s;
    }
  }
}

// Column c of L^-1, from its diagonal on.
template <int rows>
INLINE void inverse_column(const C (*lower)[rows], int c, C* x) {
  x[c] = {splat(1.0), splat(0.0)};
  for (int i = c + 1; i < rows; ++i) {
    x[i] = C{};
    for (int j = c; j < i; ++j) subtract_product(x[i], lower[i][j], x[j]);
  }
}

}  // namespace
}  // namespace gsp
