// Python bindings of reach.hpp.
#include "bindings.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <optional>
#include <tuple>
#include <vector>

#include "drives.hpp"
#include "threads.hpp"

using namespace nanobind::literals;

namespace gsp {
namespace {

Ball ball(const double* pair) { return {pair[0], pair[1]}; }

void balls(const Array<double, 3>& array, std::size_t row, Ball* out) {
  for (int i = 0; i < 3; ++i) out[i] = ball(array.data() + (3 * row + i) * 2);
}

Reach system(const Array<std::int32_t, 1>& measures, const Array<bool, 1>& moduli,
             const Array<double, 4>& vectors, const Array<double, 3>& ranges,
             const Array<std::int32_t, 1>& legs, const Array<bool, 1>& of_base,
             const Array<double, 3>& axes, const Array<double, 2>& cosines,
             const Array<std::int32_t, 1>& turn) {
  const std::size_t count = measures.shape(0), cones = legs.shape(0);
  require(count == 6 && moduli.shape(0) == count, "six limits");
  require(vectors.shape(0) == count && vectors.shape(1) == 4 && vectors.shape(2) == 3 &&
              vectors.shape(3) == 2,
          "vectors must have shape (6, 4, 3, 2)");
  require(ranges.shape(0) == count && ranges.shape(1) == 2 && ranges.shape(2) == 2,
          "ranges must have shape (6, 2, 2)");
  require(of_base.shape(0) == cones && axes.shape(0) == cones && axes.shape(1) == 3 &&
              axes.shape(2) == 2 && cosines.shape(0) == cones && cosines.shape(1) == 2 &&
              cones <= 12,
          "cones must have shapes (n,), axes (n, 3, 2), cosines (n, 2)");
  require(turn.shape(0) == 3, "three axes");
  Reach reach;
  for (int i = 0; i < 3; ++i) {
    require(turn.data()[i] >= 0 && turn.data()[i] < 3, "axes must be 0, 1 or 2");
    reach.turn[i] = turn.data()[i];
  }
  for (std::size_t k = 0; k < count; ++k) {
    Limit limit;
    limit.measure = static_cast<Measure>(measures.data()[k]);
    limit.modulus = moduli.data()[k];
    Ball* parts[4] = {limit.y, limit.u, limit.x, limit.v};
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 3; ++i)
        parts[j][i] = ball(vectors.data() + ((4 * k + j) * 3 + i) * 2);
    limit.low = ball(ranges.data() + 4 * k);
    limit.high = ball(ranges.data() + 4 * k + 2);
    reach.limit.push_back(limit);
  }
  for (std::size_t k = 0; k < cones; ++k) {
    Cone cone;
    cone.leg = legs.data()[k];
    require(cone.leg >= 0 && cone.leg < 6, "a cone needs one of the six constraints");
    cone.of_base = of_base.data()[k];
    balls(axes, k, cone.axis);
    cone.cosine = ball(cosines.data() + 2 * k);
    reach.cone.push_back(cone);
  }
  return reach;
}

// Rows, whether each is a slide and on the platform, working modes, vectors and numbers.
using Drives = std::tuple<Array<std::int32_t, 1>, Array<bool, 2>, Array<double, 1>, Array<double, 4>,
                          Array<double, 3>>;

void add_drives(const Drives& given, Reach& reach) {
  const auto& [rows, sorts, working_modes, vectors, numbers] = given;
  const std::size_t count = rows.shape(0);
  require(count <= 6 && sorts.shape(0) == count && sorts.shape(1) == 2 && working_modes.shape(0) == count,
          "drives must have shapes (m,), sorts (m, 2), working_modes (m,)");
  require(vectors.shape(0) == count && vectors.shape(1) == 6 && vectors.shape(2) == 3 &&
              vectors.shape(3) == 2 && numbers.shape(0) == count && numbers.shape(1) == 3 &&
              numbers.shape(2) == 2,
          "drives must have vectors (m, 6, 3, 2), numbers (m, 3, 2)");
  for (std::size_t k = 0; k < count; ++k) {
    Drive drive;
    drive.row = rows.data()[k];
    require(drive.row >= 0 && drive.row < 6 &&
                reach.limit[static_cast<std::size_t>(drive.row)].measure == Measure::kPointPoint,
            "a drive moves a point of a distance of two points");
    drive.slide = sorts.data()[2 * k];
    drive.of_platform = sorts.data()[2 * k + 1];
    drive.working_mode = working_modes.data()[k];
    require(drive.working_mode == 1.0 || drive.working_mode == -1.0, "a working mode is 1 or -1");
    Ball* parts[6] = {drive.middle, drive.along, drive.beside, drive.axis, drive.first.c, drive.last.c};
    for (int j = 0; j < 6; ++j)
      for (int i = 0; i < 3; ++i)
        parts[j][i] = ball(vectors.data() + ((6 * k + static_cast<std::size_t>(j)) * 3 +
                                             static_cast<std::size_t>(i)) * 2);
    drive.low = ball(numbers.data() + 6 * k);
    drive.high = ball(numbers.data() + 6 * k + 2);
    drive.square = ball(numbers.data() + 6 * k + 4);
    drive.at_low[0] = std::cos(drive.low.m), drive.at_low[1] = std::sin(drive.low.m);
    drive.at_high[0] = std::cos(drive.high.m), drive.at_high[1] = std::sin(drive.high.m);
    reach.drive.push_back(drive);
  }
}

// Boxes of the grid of a level that were judged.
struct Judged {
  std::vector<std::uint64_t> inside, open;
  std::vector<Conditions> inside_signs, open_left;
};

template <class T>
auto copied(const std::vector<T>& values) {
  return gsp::copied(values.data(), values.size());
}

nb::tuple judge_boxes(Array<std::int32_t, 1> measures, Array<bool, 1> moduli,
                      Array<double, 4> vectors, Array<double, 3> ranges,
                      Array<std::int32_t, 1> legs, Array<bool, 1> of_base, Array<double, 3> axes,
                      Array<double, 2> cosines, Array<std::int32_t, 1> turn,
                      Array<double, 2> bounds, Array<std::int32_t, 1> free, int level,
                      Array<std::uint64_t, 1> keys, Array<std::uint32_t, 1> left, bool split,
                      int jobs, std::optional<Drives> drives) {
  Reach reach = system(measures, moduli, vectors, ranges, legs, of_base, axes, cosines, turn);
  if (drives) add_drives(*drives, reach);
  const int dimensions = static_cast<int>(free.shape(0));
  const std::size_t count = keys.shape(0);
  require(bounds.shape(0) == kParameters && bounds.shape(1) == 2,
          "bounds must have shape (6, 2)");
  require(dimensions >= 1 && dimensions <= kParameters, "one to six parameters");
  for (int d = 0; d < dimensions; ++d)
    require(free.data()[d] >= 0 && free.data()[d] < kParameters, "parameters 0 to 5");
  require(left.shape(0) == count, "conditions of each box");
  const int bits = std::min(64 / dimensions, 52);
  require(level >= 0 && level <= bits, "the level is too deep");
  const int stride = 64 / dimensions;
  const std::uint64_t mask =
      stride == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << stride) - 1;
  double centre[kParameters], half[kParameters], step[kParameters], pad[kParameters];
  for (int i = 0; i < kParameters; ++i) {
    centre[i] = bounds.data()[2 * i];
    half[i] = 0.0;
  }
  for (int d = 0; d < dimensions; ++d) {
    const int i = free.data()[d];
    const double low = bounds.data()[2 * i], high = bounds.data()[2 * i + 1];
    require(low < high && std::isfinite(high - low), "bounds must be finite and increase");
    step[i] = std::ldexp(high - low, -level);
    // Corners as they are computed here and elsewhere are off by roundings.
    pad[i] = 0x1p-48 * std::max(std::abs(low), std::abs(high));
    half[i] = step[i] * 0.5 * (1.0 + 0x1p-40) + pad[i];
  }
  const std::size_t piece =
      jobs <= 1 ? std::max<std::size_t>(count, 1)
                : std::max<std::size_t>(64, count / (8 * static_cast<std::size_t>(jobs)));
  std::vector<Judged> found(count ? (count + piece - 1) / piece : 0);
  {
    nb::gil_scoped_release release;
    std::atomic<std::size_t> next{0};
    const auto work = [&] {
      double middle[kParameters], radius[kParameters], twice[kParameters];
      std::copy(centre, centre + kParameters, middle);
      std::copy(half, half + kParameters, radius);
      for (int i = 0; i < kParameters; ++i) twice[i] = 2.0 * half[i];
      std::optional<Whole> whole;
      for (std::size_t part = next++; part < found.size(); part = next++) {
        Judged& out = found[part];
        const std::size_t end = std::min(count, (part + 1) * piece);
        for (std::size_t box = part * piece; box < end; ++box) {
          if (split && !reach.drive.empty()) {
            for (int d = 0; d < dimensions; ++d) {
              const int i = free.data()[d];
              const std::uint64_t place = keys.data()[box] >> (d * stride) & mask;
              middle[i] = bounds.data()[2 * i] + (static_cast<double>(place) + 0.5) * 2.0 * step[i];
            }
            whole.emplace(reach, middle, twice, left.data()[box]);
          }
          for (int child = 0; child < (split ? 1 << dimensions : 1); ++child) {
            std::uint64_t key = 0;
            for (int d = 0; d < dimensions; ++d) {
              std::uint64_t place = keys.data()[box] >> (d * stride) & mask;
              if (split) place = 2 * place + (child >> d & 1);
              key |= place << (d * stride);
              const int i = free.data()[d];
              middle[i] = bounds.data()[2 * i] + (static_cast<double>(place) + 0.5) * step[i];
            }
            Conditions open = left.data()[box];
            switch (judge(reach, middle, radius, open, whole ? &*whole : nullptr)) {
              case Verdict::kInside:
                out.inside.push_back(key);
                out.inside_signs.push_back(open);
                break;
              case Verdict::kOpen:
                out.open.push_back(key);
                out.open_left.push_back(open);
                break;
              default:;
            }
          }
        }
      }
    };
    share(jobs, found.size(), work);
  }
  Judged all;
  const auto append = [](auto& to, const auto& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  for (const Judged& part : found) {
    append(all.inside, part.inside);
    append(all.inside_signs, part.inside_signs);
    append(all.open, part.open);
    append(all.open_left, part.open_left);
  }
  return nb::make_tuple(copied(all.inside), copied(all.inside_signs), copied(all.open),
                        copied(all.open_left));
}

nb::object connected_boxes(Array<std::uint64_t, 1> keys, Array<std::int32_t, 1> levels,
                           int dimensions, bool touching, Array<bool, 1> periodic, int poles) {
  require(dimensions >= 1 && dimensions <= kParameters, "one to six parameters");
  require(periodic.shape(0) == static_cast<std::size_t>(dimensions) &&
              levels.shape(0) == keys.shape(0),
          "a level of each box, and whether each parameter is periodic");
  for (std::size_t i = 0; i < levels.shape(0); ++i)
    require(levels.data()[i] >= 0 && levels.data()[i] <= 52, "levels from 0 to 52");
  std::vector<std::int64_t> labels;
  {
    nb::gil_scoped_release release;
    labels = connected(keys.data(), levels.data(), keys.shape(0), dimensions, touching,
                       periodic.data(), poles);
  }
  return nb::cast(copied(labels));
}

}  // namespace

void bind_reach(nb::module_& m) {
  m.attr("REGULAR") = kRegular;
  m.attr("NEGATIVE") = kNegative;
  m.attr("REACH") = kReach;
  m.def("judge_boxes", &judge_boxes, "measures"_a, "moduli"_a, "vectors"_a, "ranges"_a, "legs"_a,
        "of_base"_a, "axes"_a, "cosines"_a, "turn"_a, nb::kw_only(), "bounds"_a,
        "free"_a, "level"_a, "keys"_a, "left"_a, "split"_a, "jobs"_a,
        "drives"_a = nb::none(),
        "Judge boxes of poses by limits; see gspcli.motion.workspace.pose_boxes.");
  m.def("connected_boxes", &connected_boxes, "keys"_a, "levels"_a, "dimensions"_a, "touching"_a,
        "periodic"_a, "poles"_a, "Label connected boxes; see gspcli.motion.workspace.pose_boxes.");
}

}  // namespace gsp
