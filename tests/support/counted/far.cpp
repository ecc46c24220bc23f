// Counts the roundings of far_equations.hpp. For tests/unit/motion/following/test_roundings.py.
#include <cstdio>
#include <vector>

#define GSP_PARTS 1
// A number of a lane is as long as two doubles.
#define COUNTED_LANES 2
#include "far_equations.hpp"

using namespace gsp;

int main() {
  // The equations with odd numbers are products. Numbers are rounded to one double.
  const unsigned products = 0b0101010;
  const int numbers = far_numbers(products);
  std::vector<D> re(numbers), im(numbers);
  for (int k = 0; k < numbers; ++k) re[k] = D(0.1 + 0.01 * (k % 17), 1), im[k] = D(0.2 - 0.01 * (k % 13), 1);
  Block b{reinterpret_cast<double*>(re.data()), reinterpret_cast<double*>(im.data()), nullptr, nullptr, {}, {}, {}};
  for (int r = 0, at = kFarNumbers; r < kRows; ++r)
    if (products >> r & 1) b.second[r] = at, at += kOfProduct;
  C s[kRows], shift[kRows];
  // The shift has 32 digits and is rounded to one double.
  for (int i = 0; i < kRows; ++i) s[i] = {D(0.1 + 0.1 * i, 0), D(0.3, 0)}, shift[i] = {D(0.1, 1), D(0.2, 1)};
  Linear at;
  linearize(b, shift, s, at);
  int derivative[2] = {}, product = 0, step = 0, bounds = 0;
  const C y{D(0.7, 0), D(0.6, 0)};
  for (int r = 0; r < kRows; ++r) {
    // The products with the inverse err besides the derivatives.
    C sum{D(1.0, 0), D(1.0, 0)};
    for (const C& x : at.jacobian[r]) {
      int& most = derivative[products >> r & 1];
      most = std::max(most, count(x));
      subtract_product(sum, y, C{D(x.re.v, 0), D(x.im.v, 0)});
    }
    product = std::max(product, count(sum));
  }
  C change[kRows];
  for (int i = 0; i < kRows; ++i) {
    at.value[i] = {D(0.1, 1), D(0.2, 1)};
    for (C& x : at.inverse[i]) x = y;
  }
  newton_step(at, change);
  for (const C& x : change) step = std::max(step, count(x));
  V size[kRows];
  for (V& x : size) x = D(1.3, 1);
  const Sizes sizes = sizes_of(b, 0, size);
  bounds = std::max({sizes.value.k, sizes.slope.k, sizes.curvature.k});
  std::printf("%d %d %d %d %d\n", derivative[0], derivative[1], product, step, bounds);
  std::printf("%g %g %g\n", kRounding * 0x1p53, kStepRounding * 0x1p53, (kOutward - 1.0) * 0x1p53);
}
