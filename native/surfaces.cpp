#include "surfaces.hpp"

#include <algorithm>
#include <vector>

#include "products.hpp"

namespace gsp {
namespace {

using Number = std::complex<double>;

// A basis of the f with e.f = 0, as columns: in the coordinates of the forms if there are any. Else
// it is orthogonal in the Hermitian sense, so that it stays sound where N vanishes: it comes from
// the reflection that takes the first unit vector into a multiple of conj(e).
void make_basis(const Number* e, const double* forms, Number (*basis)[3]) {
  if (forms) {
    for (int l = 0; l < 4; ++l)
      for (int c = 0; c < 3; ++c) {
        basis[l][c] = 0.0;
        for (int k = 0; k < 4; ++k) basis[l][c] += 0.25 * forms[16 * c + 4 * k + l] * e[k];
      }
    return;
  }
  Number mirror[4];
  for (int i = 0; i < 4; ++i) mirror[i] = std::conj(e[i]);
  const double size = std::abs(mirror[0]);
  mirror[0] += size > 0.0 ? mirror[0] / size : 1.0;
  double square = 0.0;
  for (const Number& x : mirror) square += std::norm(x);
  for (int l = 0; l < 4; ++l)
    for (int c = 0; c < 3; ++c)
      basis[l][c] = (l == c + 1 ? 0.5 : 0.0) -
                    product(mirror[l], std::conj(mirror[c + 1])) / square;
}

}  // namespace

void make_surfaces(const Measures& given, const Number* e, const double* flat,
                   const double* curved, const Surfaces& out) {
  Number basis[4][3], norm = 0.0;
  make_basis(e, given.basis, basis);
  for (int k = 0; k < 4; ++k) norm += product(e[k], e[k]);
  for (int l = 0; l < 4; ++l)
    for (int c = 0; c < 3; ++c) out.basis[3 * l + c] = basis[l][c];

  // Each form as a linear form in (s, t).
  std::vector<Number> linear(4 * given.forms());
  for (int i = 0; i < given.forms(); ++i) {
    Number row[8] = {};
    for (int k = 0; k < 4; ++k)
      for (int l = 0; l < 8; ++l) row[l] += given.form[32 * i + 8 * k + l] * e[k];
    Number* form = &linear[4 * i];
    for (int l = 0; l < 4; ++l) {
      form[0] += product(row[l], e[l]);
      for (int c = 0; c < 3; ++c) form[1 + c] += product(row[4 + l], basis[l][c]);
    }
  }
  const Number* heights = linear.data();
  const Number* squares = heights + 4 * given.heights;
  const Number* axial = squares + 4 * given.squares();
  const Number* normals = axial + 4 * given.cylinders;

  Number metric[3][3] = {};
  for (int c = 0; c < 3; ++c)
    for (int d = 0; d < 3; ++d)
      for (int l = 0; l < 4; ++l) metric[c][d] += 4.0 * product(basis[l][c], basis[l][d]);
  for (int i = 0; i < given.squares(); ++i) {
    Number(*q)[4] = reinterpret_cast<Number(*)[4]>(out.quadric + 16 * i);
    q[0][0] = squares[4 * i] - curved[i] * curved[i] * norm;
    for (int c = 0; c < 3; ++c) {
      q[0][1 + c] = q[1 + c][0] = 0.5 * squares[4 * i + 1 + c];
      for (int d = 0; d < 3; ++d) q[1 + c][1 + d] = metric[c][d];
    }
    if (i < given.spheres) continue;
    const Number* along = axial + 4 * (i - given.spheres);
    for (int c = 0; c < 4; ++c)
      for (int d = 0; d < 4; ++d)
        q[c][d] = product(norm, q[c][d]) - product(along[c], along[d]);
  }

  // What a distance adds to the first coefficient of a plane.
  std::vector<Number> offset(given.heights);
  for (int j = 0; j < given.heights; ++j) offset[j] = flat[j] * norm;
  *out.skewness = 1.0;
  for (int p = 0; p < given.pairs; ++p) {
    Number square = 0.0;
    for (int i = 0; i < 3; ++i)
      square += product(normals[12 * p + 4 * i], normals[12 * p + 4 * i]);
    offset[given.skew[p]] = flat[given.skew[p]] * std::sqrt(square);
    *out.skewness = std::min(*out.skewness, std::abs(square) / std::norm(norm));
  }
  for (int s = 0; s < given.signs; ++s) {
    Number* plane = out.plane + 4 * s * given.planes();
    std::copy(heights, heights + 4 * given.heights, plane);
    for (int j = 0; j < given.heights; ++j)
      plane[4 * j] -= given.sign[s * given.heights + j] * offset[j];
    // Spheres differ by the plane of their common circle.
    for (int i = 0; i < given.circles(); ++i)
      for (int c = 0; c < 4; ++c)
        plane[4 * (given.heights + i) + c] =
            (c ? 2.0 : 1.0) * (out.quadric[16 * (i + 1) + c] - out.quadric[c]);
  }
}

}  // namespace gsp
