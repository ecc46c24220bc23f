// Python bindings of gaps.hpp.
#include "bindings.hpp"

#include <cstdint>

#include "gaps.hpp"

using namespace nanobind::literals;

namespace gsp {
namespace {

nb::tuple hull_gaps(Array<double, 3> points, Array<std::int64_t, 1> starts,
                    Array<std::int64_t, 2> pairs) {
  const std::size_t poses = points.shape(0), count = points.shape(1), pair_count = pairs.shape(0);
  const std::size_t hulls = starts.shape(0);
  require(points.shape(2) == 3 && pairs.shape(1) == 2, "points (n, m, 3) and pairs (p, 2)");
  require(hulls > 0 && starts.data()[0] == 0 &&
              static_cast<std::size_t>(starts.data()[hulls - 1]) == count,
          "starts of the hulls, from 0 to the number of points");
  for (std::size_t k = 1; k < hulls; ++k)
    require(starts.data()[k - 1] < starts.data()[k], "a hull needs a point");
  for (std::size_t k = 0; k < 2 * pair_count; ++k)
    require(pairs.data()[k] >= 0 && static_cast<std::size_t>(pairs.data()[k]) + 1 < hulls,
            "pairs of hulls");
  auto low = std::make_unique<double[]>(poses * pair_count);
  auto high = std::make_unique<double[]>(poses * pair_count);
  {
    nb::gil_scoped_release release;
    for (std::size_t i = 0; i < poses; ++i)
      for (std::size_t k = 0; k < pair_count; ++k) {
        const double* hull[2];
        int size[2];
        for (int j = 0; j < 2; ++j) {
          const auto which = static_cast<std::size_t>(pairs.data()[2 * k + static_cast<std::size_t>(j)]);
          const std::int64_t begin = starts.data()[which];
          hull[j] = points.data() + 3 * (i * count + static_cast<std::size_t>(begin));
          size[j] = static_cast<int>(starts.data()[which + 1] - begin);
        }
        const Gap found = hull_gap(hull[0], size[0], hull[1], size[1]);
        low[i * pair_count + k] = found.low;
        high[i * pair_count + k] = found.high;
      }
  }
  return nb::make_tuple(owned(std::move(low), {poses, pair_count}),
                        owned(std::move(high), {poses, pair_count}));
}

}  // namespace

void bind_gaps(nb::module_& m) {
  m.def("hull_gaps", &hull_gaps, "points"_a, "starts"_a, "pairs"_a,
        "Bound distances of convex hulls; see gspcli.motion.collisions.");
}

}  // namespace gsp
