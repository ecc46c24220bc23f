// The product of complex numbers that are finite.
#pragma once

#include <complex>

namespace gsp {

// Without the checks for infinity of the standard product, which make it slow.
inline std::complex<double> product(const std::complex<double>& a, const std::complex<double>& b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

}  // namespace gsp
