// The order of poses that does not depend on how they were found.
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdint>
#include <memory>
#include <numeric>
#include <vector>

#include "bindings.hpp"

using namespace nanobind::literals;

namespace gsp {
namespace {

constexpr int kQuaternion = 4, kCoordinates = 3, kNumbers = kQuaternion + kCoordinates;
// Nine decimals count.
constexpr double kDecimals = 1e9;

struct Key {
  std::array<double, 4 * kNumbers> number;  // rounded, then unrounded; real parts first
  bool real;

  // NaN comes last.
  bool operator<(const Key& other) const {
    if (real != other.real) return real;
    for (std::size_t i = 0; i < number.size(); ++i) {
      const double a = number[i], b = other.number[i];
      if (a < b || b < a) return a < b;
      if (std::isnan(a) != std::isnan(b)) return std::isnan(b);
    }
    return false;
  }
};

nb::object order(Array<bool, 1> real, Array<std::complex<double>, 2> quaternions,
                 Array<std::complex<double>, 2> translations, double unit) {
  const std::size_t count = real.shape(0);
  require(quaternions.shape(0) == count && quaternions.shape(1) == kQuaternion &&
              translations.shape(0) == count && translations.shape(1) == kCoordinates,
          "real, quaternions and translations must have shapes (n,), (n, 4) and (n, 3)");
  std::vector<Key> keys(count);
  for (std::size_t i = 0; i < count; ++i) {
    keys[i].real = real(i);
    for (int k = 0; k < kNumbers; ++k) {
      const bool turning = k < kQuaternion;
      const std::complex<double> x = turning ? quaternions(i, k) : translations(i, k - kQuaternion),
                                 part = turning ? x : x * (1.0 / unit);
      keys[i].number[k] = std::rint(part.real() * kDecimals);
      keys[i].number[kNumbers + k] = std::rint(part.imag() * kDecimals);
      keys[i].number[2 * kNumbers + k] = x.real();
      keys[i].number[3 * kNumbers + k] = x.imag();
    }
  }
  auto found = std::make_unique<std::int64_t[]>(count);
  std::iota(found.get(), found.get() + count, std::int64_t{0});
  std::stable_sort(found.get(), found.get() + count,
                   [&](std::int64_t a, std::int64_t b) { return keys[a] < keys[b]; });
  return nb::cast(owned(std::move(found), {count}));
}

}  // namespace

void bind_ordering(nb::module_& m) {
  m.def("order", &order, "real"_a, "quaternions"_a, "translations"_a, nb::kw_only(), "unit"_a,
        "Return the permutation that sorts poses; see gspcli.geometry.quaternions.");
}

}  // namespace gsp
