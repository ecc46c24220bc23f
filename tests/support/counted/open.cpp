// Sizes of sums of doubles after terms cancel. For tests/unit/motion/following/test_roundings.py.
#include <cstdio>
#include <initializer_list>

#include "open_equations.cpp"

int main() {
  using namespace gsp;
  const Doubled a{3.0, 0x1p-60, 3.0}, b{3.0, -0x1p-60, 3.0}, two{2.0, 0.0, 2.0};
  const Doubled row[3] = {a, b, two}, other[3] = {two, -two, two};
  for (const Doubled& x : {a - b, -a + b, (a - b) * two, dot(row, other), 0.5 * (a - b)})
    std::printf("%.17g %.17g\n", x.high + x.low, x.size);
  const Vector c = cross(row, row);
  for (const Doubled& x : c.entry) std::printf("%.17g %.17g\n", x.high + x.low, x.size);
}
