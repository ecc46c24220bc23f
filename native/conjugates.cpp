#include "conjugates.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace gsp {
namespace {

using Number = std::complex<double>;

double norm_of(int size, const Number* z) {
  double s = 0.0;
  for (int c = 0; c < size; ++c) s += std::norm(z[c]);
  return std::sqrt(s);
}

// The squared distance of conj(z) from w, both of norm 1, in the phase of w where it is least. Not
// from the cosine of the angle, whose rounding hides distances below 1e-8.
double distance(int size, const Number* z, const Number* w) {
  double re = 0.0, im = 0.0;
  for (int c = 0; c < size; ++c) {
    re += z[c].real() * w[c].real() - z[c].imag() * w[c].imag();
    im += z[c].real() * w[c].imag() + z[c].imag() * w[c].real();
  }
  const double overlap = std::hypot(re, im), scale = overlap > 0.0 ? 1.0 / overlap : 0.0;
  const double cosine = overlap > 0.0 ? re * scale : 1.0, sine = im * scale;
  double s = 0.0;
  for (int c = 0; c < size; ++c) {
    const double x = z[c].real() - (cosine * w[c].real() + sine * w[c].imag());
    const double y = -z[c].imag() - (cosine * w[c].imag() - sine * w[c].real());
    s += x * x + y * y;
  }
  return s;
}

}  // namespace

void find_real_points(int count, int size, const Number* point, Number* representative,
                      bool* real) {
  // |k.z|^2 for a real k: the same for conjugate points, and of nearly the same value for near ones.
  std::vector<double> key(count), weight(size);
  double square = 0.0;
  for (int c = 0; c < size; ++c) {
    weight[c] = std::cos(1.0 + c * c);
    square += weight[c] * weight[c];
  }
  for (int i = 0; i < count; ++i) {
    Number* z = representative + i * size;
    const double scale = 1.0 / norm_of(size, point + i * size);
    Number s = 0.0;
    for (int c = 0; c < size; ++c) {
      z[c] = scale * point[i * size + c];
      s += weight[c] * z[c];
    }
    key[i] = std::isfinite(std::norm(s)) ? std::norm(s) : 0.0;
  }
  std::vector<int> order(count);
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int i, int j) { return key[i] < key[j]; });

  for (int at = 0; at < count; ++at) {
    const int i = order[at];
    const Number* z = representative + i * size;
    const double own = distance(size, z, z);
    // Points within that distance of conj(z) have a key that differs by no more than this.
    const double reach = 2.0 * square * std::sqrt(own) + 1e-14 * square;
    bool alone = true;
    int below = at - 1, above = at + 1;
    while (alone) {
      const double down = below >= 0 ? key[i] - key[order[below]] : HUGE_VAL;
      const double up = above < count ? key[order[above]] - key[i] : HUGE_VAL;
      if (!(std::min(down, up) <= reach)) break;
      const int next = down < up ? order[below--] : order[above++];
      alone = !(distance(size, z, representative + next * size) < own);
    }
    real[i] = alone;
  }

  for (int i = 0; i < count; ++i) {
    if (!real[i]) continue;
    Number* z = representative + i * size;
    const Number pivot =
        *std::max_element(z, z + size, [](auto& a, auto& b) { return std::norm(a) < std::norm(b); });
    const Number phase = std::conj(pivot) / std::abs(pivot);
    for (int c = 0; c < size; ++c)
      z[c] = z[c].real() * phase.real() - z[c].imag() * phase.imag();
    const double scale = 1.0 / norm_of(size, z);
    for (int c = 0; c < size; ++c) z[c] *= scale;
  }
}

}  // namespace gsp
