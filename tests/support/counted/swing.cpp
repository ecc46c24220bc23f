// How far the point of a motor moves in a box of poses, and the bound of it. For
// tests/unit/motion/following/test_roundings.py.
#include <cmath>
#include <cstdio>

#include "drives.cpp"
#include "pose_box.cpp"

using namespace gsp;

namespace {

// By an angle about the axis x.
void turned(double angle, const double* a, double* out) {
  out[0] = a[0];
  out[1] = std::cos(angle) * a[1] - std::sin(angle) * a[2];
  out[2] = std::sin(angle) * a[1] + std::cos(angle) * a[2];
}

double length(const double* a) { return std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]); }

// The largest part of the bound that occurs, or -1 if nothing is proved.
double worst(bool slide, bool of_platform, double working_mode, double rho) {
  const double wanted = slide ? 0.1 : 0.7, arm = slide ? 1.0 : 0.2;
  const double along[3] = {slide ? 0.0 : arm, slide ? arm : 0.0, 0.0}, beside[3] = {0.0, slide ? 0.0 : arm, 0.0};
  const auto point = [&](double q, double* out) {
    for (int i = 0; i < 3; ++i)
      out[i] = slide ? along[i] * q : along[i] * std::cos(q) + beside[i] * std::sin(q);
  };
  const double other[3] = {0.5, 0.1, -1.0};
  double at_q[3], square = 0.0;
  point(wanted, at_q);
  for (int i = 0; i < 3; ++i) square += (at_q[i] - other[i]) * (at_q[i] - other[i]);
  Drive drive{};
  drive.row = 0, drive.slide = slide, drive.of_platform = of_platform, drive.working_mode = working_mode;
  for (int i = 0; i < 3; ++i) {
    drive.along[i] = {along[i], 0.0}, drive.beside[i] = {beside[i], 0.0}, drive.middle[i] = {0.0, 0.0};
    drive.axis[i] = {i == 2 ? 1.0 : 0.0, 0.0};
  }
  drive.low = {-3.0, 0.0}, drive.high = {3.0, 0.0}, drive.square = {square, 0.0};
  Limit limit{};
  limit.measure = Measure::kPointPoint;
  for (int i = 0; i < 3; ++i) (of_platform ? limit.x : limit.y)[i] = {other[i], 0.0};
  Reach reach{};
  for (int i = 0; i < 3; ++i) reach.turn[i] = i;
  const double centre[6] = {}, half[6] = {0.0, 0.0, 0.0, rho, 0.0, 0.0};
  const Place box = place(reach, centre, half);
  Placed leg;
  Swing swing;
  if (!locate(drive, limit, box, leg, swing) || std::fabs(swing.q - wanted) > 0.3) return -1.0;
  double most = 0.0, first[3];
  point(swing.q, first);
  for (const double part : {-1.0, 1.0})
    for (const double turn : {-1.0, 0.0, 1.0}) {
      double there[3], moved[3];
      point(swing.q + part * swing.delta, there);
      for (int i = 0; i < 3; ++i) there[i] -= first[i];
      turned(of_platform ? turn * rho : 0.0, there, moved);
      for (int i = 0; i < 3; ++i) moved[i] -= part * swing.delta * swing.rate[i].m;
      most = std::fmax(most, length(moved));
    }
  return swing.bend == 0.0 ? (most < 1e-15 ? 0.0 : 9.0) : most / swing.bend;
}

}  // namespace

int main() {
  for (const bool slide : {false, true})
    for (const bool of_platform : {false, true})
      for (const double rho : {1e-3, 0.02})
        std::printf("%d %d %g\n", slide, of_platform,
                    std::fmax(worst(slide, of_platform, 1.0, rho), worst(slide, of_platform, -1.0, rho)));
}
