// From the coefficients of two systems, as Python has them, to the homotopy between them.
#pragma once

#include <complex>

#include "tracker.hpp"

namespace gsp {

constexpr int kCoefficients = 27;  // of e_i e_j, e_i f_j, f.f, as in gspcli.continuation.quadrics

// One end of a homotopy: six first and six second factors (6, 27), and tau of the products.
struct Side {
  const std::complex<double>* g;
  const std::complex<double>* h;
  const std::complex<double>* tau;
};

// The straight line from one system to another; `products` says which equations are products.
// Where the target's numbers are known to more than doubles, `more` has kMore sides that are to be
// added to it; else it is null.
void make_homotopy(const bool* products, const Side& start, const Side& target, const Side* more,
                   Homotopy& H);

// The same if it is real as a RealHomotopy is, at both ends up to rounding; returns whether it is.
bool make_real_homotopy(const bool* products, const Side& start, const Side& target, RealHomotopy& H);

}  // namespace gsp
