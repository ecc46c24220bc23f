// Proofs of the kernel of live pages, one by one, for tests/unit/pictures/test_live.py.
#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include "clearance.hpp"
#define private public
#include "proofs.hpp"

#define SHOWN extern "C" __attribute__((visibility("default")))

SHOWN double clearance(const double* numbers, const double* pose) {
  gsp::live::Numbers read(numbers);
  const gsp::live::Clearance found(read);
  double R[3][3];
  std::copy(pose, pose + 9, &R[0][0]);
  return found(R, pose + 9);
}

SHOWN int is_pose(int bits) { return gsp::live::is_pose(static_cast<std::uint8_t>(bits)); }

// Real poses (count, 12), and bounds of their errors.
SHOWN int different(int count, const double* entries, const double* deviations, double scale) {
  gsp::live::Found found(count);
  for (int p = 0; p < count; ++p) {
    for (int k = 0; k < 9; ++k) found.rotation[9 * p + k] = {entries[12 * p + k], 0.0};
    for (int k = 0; k < 3; ++k) found.translation[3 * p + k] = {entries[12 * p + 9 + k], 0.0};
    found.deviation[p] = deviations[p];
  }
  return found.are_different(scale);
}

SHOWN int skew(const double* numbers, const double* rotation, double deviation) {
  gsp::live::Numbers read(numbers);
  const gsp::live::Proofs proofs(read);
  gsp::Complex R[9];
  for (int k = 0; k < 9; ++k) R[k] = {rotation[k], 0.0};
  return proofs.are_skew(R, deviation);
}

// In the place of the proofs of poses far away: each errs by one in units of its own equations.
namespace gsp {
void decide_far_portable(const FarGeometry& geometry, const FarValues&, double*, const Poses& out) {
  for (int k = 0; k < geometry.count; ++k) out.deviation[k] = 1.0;
}
}  // namespace gsp

// The error of a pose far away in units of the other equations.
SHOWN double far_deviation(double far_scale, double scale) {
  const double nothing[1] = {0.0}, zeros[64] = {};
  gsp::live::Numbers read(nothing);
  gsp::live::FarPart part(read);
  part.count_ = 1;
  part.real_ = {1}, part.paired_ = {0};
  part.values_ = part.powers_ = zeros;
  part.scale_ = far_scale;
  return part.beside(gsp::live::Found(0), zeros, 1.0, scale).deviation[0];
}
