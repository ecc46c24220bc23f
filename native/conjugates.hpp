// Which points of a set that is closed under conjugation are real.
#pragma once

#include <complex>

namespace gsp {

// A point of projective space, of points (count, size), is real if no other point of the set is
// nearer to its conjugate. `representative` has the points with norm 1; real points have real
// coordinates.
void find_real_points(int count, int size, const std::complex<double>* point,
                      std::complex<double>* representative, bool* real);

}  // namespace gsp
