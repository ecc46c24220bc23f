// Derivatives of points and of what the platform sees, by unit twists, and their bounds in the controller.
// For tests/unit/motion/following/test_roundings.py.
#include <cmath>
#include <cstdio>
#include <cstring>
#include <random>

#define HAS_DPP 1
#define HAS_DPL 1
#define HAS_DLP 1
#define HAS_DPH 1
#define HAS_DHP 1
#define HAS_DLL 1
#define HAS_ALL 1
#define HAS_ALH 1
#define HAS_AHL 1
#define HAS_AHH 1
#define HAS_BASE_CRANK 1
#define HAS_PLATFORM_CRANK 1
#define HAS_BASE_SLIDE 1
#define HAS_PLATFORM_SLIDE 1
#define HAS_CONES 1

#include "controller.hpp"
namespace {
#include "../gspcli/export/controller/platform.c"

void cross_of(const double* a, const double* b, double* out) {
  for (int i = 0; i < 3; ++i) out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}
}  // namespace

int main() {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  double worst[2][4] = {};
  for (int n = 0; n < 200000; ++n) {
    double w[3], t[3], way[3], size = 0.0;
    for (int i = 0; i < 3; ++i) {
      w[i] = normal(random), t[i] = normal(random), way[i] = normal(random);
      size += w[i] * w[i] + t[i] * t[i];
    }
    for (int i = 0; i < 3; ++i) w[i] /= std::sqrt(size), t[i] /= std::sqrt(size);
    geometry g{};
    frame f{};
    const double far = std::exp(normal(random)), radius = n % 2 ? 0.5 * far : 0.0;
    double x[3], scale = length(way);
    for (int i = 0; i < 3; ++i) way[i] /= scale, x[i] = (far + radius) * way[i], f.T[i] = far * way[i];
    double e[4];
    seen(&g, &f, 0, radius, e);
    // Of exp(-s w) (x - s t) at s = 0.
    double a[3], b[3], c[3], d[3], u[3];
    cross_of(w, x, a), cross_of(w, a, b), cross_of(w, b, c), cross_of(w, t, d), cross_of(w, d, u);
    double of[4][3];
    for (int i = 0; i < 3; ++i) {
      of[1][i] = -a[i] - t[i];
      of[2][i] = b[i] + 2.0 * d[i];
      of[3][i] = -c[i] - 3.0 * u[i];
    }
    for (int k = 1; k < 4; ++k) worst[0][k] = std::fmax(worst[0][k], length(of[k]) / e[k]);
    // Of exp(s w) x + s t.
    moved(length(x), e);
    for (int i = 0; i < 3; ++i) of[1][i] = a[i] + t[i], of[2][i] = b[i], of[3][i] = c[i];
    for (int k = 1; k < 4; ++k) worst[1][k] = std::fmax(worst[1][k], length(of[k]) / e[k]);
  }
  for (auto& row : worst) std::printf("%g %g %g\n", row[1], row[2], row[3]);
}
