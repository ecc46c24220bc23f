#include "far_module.hpp"

#include <nanobind/stl/string.h>

#include <algorithm>
#include <atomic>
#include <complex>
#include <memory>
#include <vector>

#include "bindings.hpp"
#include "threads.hpp"

using namespace nanobind::literals;

namespace gsp {
namespace {

using Numbers = std::complex<double>;

// So many sets of values share the numbers of the poses, put in the order of the lanes.
constexpr std::size_t kTogether = 64;
constexpr std::size_t kShifts = 3;

DecideFar* (*choose_build)(const std::string& build);

nb::tuple decide_far(Array<Numbers, 3> numbers, Array<double, 1> errors, Array<std::uint8_t, 1> real,
                     Array<double, 3> shifts, Array<Numbers, 3> local, Array<double, 1> units, double scale, double tolerance, int jobs,
                     const std::string& build) {
  const std::size_t count = errors.shape(0), sets = units.shape(0), three = 3, four = 4;
  require(numbers.shape(0) == 2 && numbers.shape(1) == count && numbers.shape(2) == kFarNumbers &&
              real.shape(0) == count,
          "numbers, errors and real must have shapes (2, count, 752), (count,) and (count,)");
  require(shifts.shape(0) == sets && shifts.shape(1) == kShifts && shifts.shape(2) == kEquations,
          "shifts and units must have shapes (sets, 3, 6) and (sets,)");
  require(local.shape(0) == sets && local.shape(1) == count && local.shape(2) == kLocal,
          "local must have shape (sets, count, 7)");
  const auto* given = reinterpret_cast<const Complex*>(numbers.data());
  const FarGeometry geometry{static_cast<int>(count), given, given + count * kFarNumbers, errors.data(),
                             real.data(), scale, tolerance};
  const std::size_t real_count = std::count(real.data(), real.data() + count, 1);
  const std::size_t poses = 2 * count - real_count, total = sets * poses;
  auto rotation = std::make_unique<Numbers[]>(total * 9);
  auto translation = std::make_unique<Numbers[]>(total * 3);
  auto quaternion = std::make_unique<Numbers[]>(total * 4);
  auto deviation = std::make_unique<double[]>(total);
  auto proved = std::make_unique<std::uint8_t[]>(total);
  auto complete = std::make_unique<std::uint8_t[]>(sets);
  DecideFar* const run = choose_build(build);
  {
    nb::gil_scoped_release release;
    const std::size_t pieces = (sets + kTogether - 1) / kTogether;
    std::atomic<std::size_t> next{0};
    const auto work = [&] {
      std::vector<double> room(kFarRoom);
      for (std::size_t piece = next++; piece < pieces; piece = next++) {
        const std::size_t begin = piece * kTogether, size = std::min(kTogether, sets - begin), at = begin * poses;
        run(geometry,
            {static_cast<int>(size), shifts.data() + begin * kShifts * kEquations,
             reinterpret_cast<const Complex*>(local.data() + begin * count * kLocal), units.data() + begin},
            room.data(),
            {reinterpret_cast<Complex*>(rotation.get() + at * 9),
             reinterpret_cast<Complex*>(translation.get() + at * 3),
             reinterpret_cast<Complex*>(quaternion.get() + at * 4), deviation.get() + at, proved.get() + at,
             complete.get() + begin});
      }
    };
    share(jobs, pieces, work);
  }
  return nb::make_tuple(owned(std::move(rotation), {sets, poses, three, three}),
                        owned(std::move(translation), {sets, poses, three}),
                        owned(std::move(quaternion), {sets, poses, four}),
                        owned(std::move(deviation), {sets, poses}), owned(std::move(proved), {sets, poses}),
                        owned(std::move(complete), {sets}));
}

}  // namespace

void bind_far_poses(nb::module_& m, DecideFar* (*choose)(const std::string& build)) {
  choose_build = choose;
  m.def("decide_far", &decide_far, "numbers"_a, "errors"_a, "real"_a, "shifts"_a, "local"_a, "units"_a, nb::kw_only(),
        "scale"_a, "tolerance"_a, "jobs"_a = 1, "build"_a = "",
        "Prove poses far away in local coordinates; see gspcli.certification.poses.far_poses.");
}

}  // namespace gsp
