#include "isolation.hpp"

namespace gsp {
namespace {

constexpr int kNewtonSteps = 2;

void prove(const ProofSystem& system, int count, const Complex* points,
           const std::int32_t* patches, const ProofResults& out) {
  for (int begin = 0; begin < count; begin += W) {
    C z[N];
    Mask above[kRows], below[kRows];
    Isolation found;
    for (int l = 0; l < W; ++l) {
      // Lanes that are left over repeat the last point.
      const int p = begin + l < count ? begin + l : count - 1;
      for (int i = 0; i < N; ++i) put(z[i], l, points[N * p + i]);
      for (int k = 0; k < kRows; ++k) {
        above[k][l] = patches[p] <= k ? -1 : 0;
        below[k][l] = patches[p] <= k ? 0 : -1;
      }
    }
    prove_lanes(system, kNewtonSteps, z, above, below, found);
    for (int l = 0; l < W && begin + l < count; ++l) {
      const int p = begin + l;
      for (int i = 0; i < N; ++i) out.point[N * p + i] = lane(z[i], l);
      out.error[p] = lane(found.error, l);
      out.proved[p] = static_cast<std::uint8_t>((found.isolated[l] ? kIsolated : 0) |
                                                (found.real[l] ? kReal : 0) |
                                                (found.imaginary[l] ? kComplex : 0));
    }
  }
}

}  // namespace

void GSP_PROVE(const ProofSystem& system, int count, const Complex* points,
               const std::int32_t* patches, const ProofResults& results) {
  prove(system, count, points, patches, results);
}

}  // namespace gsp
