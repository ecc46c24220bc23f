// The positions of a platform with a known orientation (Propositions 6.4, 6.5 and 6.7); plain data.
//
// With the rotation fixed, each distance constraint keeps the translation T on a surface: DPH, DHP
// and DLL on a plane or two parallel ones, DPP on a sphere, DPL and DLP on a circular cylinder,
// and so does DLL when its lines are parallel. Three such surfaces meet in 2^m points, m of them
// being quadrics once the differences of spheres have been replaced by planes.
//
// Coordinates are X = (s, t), homogeneous in a basis B of the f with e.f = 0: the Study point of
// X is (s e, B t). Surfaces are forms in X, and a plane is a vector of length 4, a quadric a
// symmetric matrix of order 4. At a complex rotation N may be small and R large. The forms are made
// of the quaternion, nowhere divided by N and without cancellation, so that they stay accurate.
// Lengths should be of order one and the points near the origin.
#pragma once

#include <complex>

namespace gsp {

// Real forms in the Study parameters (e, f), (4, 8) each. In this order: heights over planes and
// moments of lines; squares, of spheres, then of cylinders; heights along the axes of the
// cylinders; three normals of each pair of lines. See gspcli.geometry.measurement.
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
  int forms() const { return heights + squares() + cylinders + 3 * pairs; }
};

// Surfaces at one rotation; those of real rotations are exactly real.
struct Surfaces {
  std::complex<double>* plane;    // (signs, planes, 4): heights, then circles of the first sphere
  std::complex<double>* quadric;  // (squares, 4, 4): spheres first
  std::complex<double>* basis;    // (4, 3): of the f
  double* skewness;               // least squared sine, in absolute value, of pairs of lines
};

// At the quaternion e, the distances (heights) and (squares) given apart.
void make_surfaces(const Measures&, const std::complex<double>* e, const double* flat,
                   const double* curved, const Surfaces&);

}  // namespace gsp
