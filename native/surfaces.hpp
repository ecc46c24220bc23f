// The surfaces on which distances keep the translation at given rotations; plain data.
#pragma once

#include <complex>

namespace gsp {

// Forms in the Study parameters (e, f), real, (4, 8) each: heights over planes and moments of lines,
// squares (of spheres, then of cylinders), heights along the axes of the cylinders, three normals of
// each pair of lines, N T. See gspcli.geometry.distance_forms.
struct Measures {
  int heights, spheres, cylinders, pairs;
  const double* form;
  const int* skew;      // (pairs): which heights are moments
  int signs;            // combinations of sides
  const double* sign;   // (signs, heights)
  const double* basis;  // (3, 4, 4): forms of T or of U, which are the coordinates; or null
  int squares() const { return spheres + cylinders; }
  int circles() const { return spheres > 1 ? spheres - 1 : 0; }
  int planes() const { return heights + circles(); }
  int forms() const { return heights + squares() + cylinders + 3 * pairs + 3; }
};

// Surfaces at one rotation; see gspcli.geometry.surfaces.
struct Surfaces {
  std::complex<double>* plane;    // (signs, planes, 4)
  std::complex<double>* quadric;  // (squares, 4, 4)
  std::complex<double>* basis;    // (4, 3)
  std::complex<double>* frame;    // (3, 3)
  double* skewness;
};

// At the quaternion e, the distances (heights) and (squares) given apart.
void make_surfaces(const Measures&, const std::complex<double>* e, const double* flat,
                   const double* curved, const Surfaces&);

}  // namespace gsp
