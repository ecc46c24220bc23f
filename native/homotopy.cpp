#include "homotopy.hpp"

#include <algorithm>
#include <cmath>

namespace gsp {
namespace {

// Features that are smaller than this part of a quadric are rounding noise, which must not take the
// path out of the linear space of quadrics that both ends are in.
constexpr double kNoise = 1e-15;

// Coefficients of e_i e_j, e_i f_j, f.f to those of the features of tracker.hpp (modulo e.f).
void to_features(const std::complex<double>* q, std::complex<double>* out) {
  const auto b = [&](int i, int j) { return q[10 + 4 * i + j]; };
  for (int i = 0; i < 10; ++i) out[i] = q[i];
  for (int i = 1; i < 4; ++i) {
    const int j = i % 3 + 1, k = j % 3 + 1;
    const std::complex<double> d = 0.25 * (b(0, i) - b(i, 0)), x = 0.25 * (b(j, k) - b(k, j));
    out[kOffsetT + i - 1] = d + x;
    out[kOffsetU + i - 1] = d - x;
  }
  int n = kOffsetS;
  for (int i = 0; i < 4; ++i)
    for (int j = i + 1; j < 4; ++j) out[n++] = 0.5 * (b(i, j) + b(j, i));
  for (int i = 1; i < 4; ++i) out[n++] = b(i, i) - b(0, 0);
  out[kOffsetRho] = q[26];
}

double size_of(const std::complex<double>* q) {
  double size = 0.0;
  for (int i = 0; i < kFeatures; ++i) size += std::norm(q[i]);
  return std::sqrt(size);
}

bool uses(const std::complex<double>* q, int begin, int end) {
  return std::any_of(q + begin, q + end, [](const auto& x) { return x != 0.0; });
}

unsigned groups(const std::complex<double>* q) {
  return (uses(q, kOffsetT, kOffsetT + 3) ? kT : 0) | (uses(q, kOffsetU, kOffsetU + 3) ? kU : 0) |
         (uses(q, kOffsetS, kOffsetS + 9) ? kS : 0) |
         (uses(q, kOffsetRho, kOffsetRho + 1) ? kRho : 0);
}

Complex plain(const std::complex<double>& x) { return {x.real(), x.imag()}; }

}  // namespace

void make_homotopy(const bool* products, const Side& start, const Side& target, Homotopy& H) {
  const Side* sides[2] = {&start, &target};
  for (int i = 0; i < kQuadrics; ++i) {
    const int row = i % kEquations;
    if (i >= kEquations && !products[row]) continue;
    std::complex<double> ends[2][kFeatures];
    unsigned used = 0;
    for (int s = 0; s < 2; ++s) {
      to_features((i < kEquations ? sides[s]->g : sides[s]->h) + row * kCoefficients, ends[s]);
      const double noise = kNoise * size_of(ends[s]);
      for (std::complex<double>& x : ends[s])
        if (std::abs(x) < noise) x = 0.0;
      used |= groups(ends[s]);
    }
    H.quadric[i].groups = used;
    for (int k = 0; k < kFeatures; ++k) {
      H.quadric[i].start[k] = plain(ends[0][k]);
      H.quadric[i].change[k] = plain(ends[1][k] - ends[0][k]);
    }
  }
  for (int i = 0; i < kEquations; ++i) {
    H.product[i] = products[i];
    H.tau_start[i] = plain(products[i] ? start.tau[i] : 0.0);
    H.tau_change[i] = plain(products[i] ? target.tau[i] - start.tau[i] : 0.0);
  }
}

}  // namespace gsp
