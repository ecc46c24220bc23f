// Which points of a set that is closed under conjugation are real.
#pragma once

#include <complex>

namespace gsp {

// Of points (count, size) of projective space those are real whose conjugate is, of all points of
// the set, nearest to themselves. `representative` are the points with norm 1, real ones real.
void find_real_points(int count, int size, const std::complex<double>* point,
                      std::complex<double>* representative, bool* real);

}  // namespace gsp
