#include "modules.hpp"

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

FarBuild (*choose_build)(const std::string& build);

// How many numbers each pose has. The first equation, e.f, is no product.
std::size_t numbers_of(unsigned products) {
  require(products >> kLocal == 0 && (products & 1) == 0, "products must be bits of six equations");
  return far_numbers(products);
}

nb::tuple decide_far(Array<Numbers, 3> numbers, Array<double, 1> errors, Array<std::uint8_t, 1> real,
                     Array<std::uint8_t, 1> paired, Array<Numbers, 1> origin, Array<Numbers, 2> starts,
                     Array<double, 3> shifts, Array<double, 1> units, double scale, double tolerance,
                     unsigned products, int jobs, const std::string& build) {
  const std::size_t count = errors.shape(0), sets = units.shape(0), three = 3, four = 4;
  const std::size_t length = numbers_of(products);
  require(numbers.shape(0) == 2 && numbers.shape(1) == count && numbers.shape(2) == length &&
              real.shape(0) == count && paired.shape(0) == count,
          "numbers, errors, real and paired must have shapes (2, count, 794 + 37 a product) and (count,)");
  require(shifts.shape(0) == sets && shifts.shape(1) == kShifts && shifts.shape(2) == kEquations,
          "shifts and units must have shapes (sets, 3, 6) and (sets,)");
  require(origin.shape(0) == kEquations && starts.shape(0) <= count && starts.shape(1) == kLocal,
          "origin and starts must have shapes (6,) and (bent, 7)");
  const auto* given = reinterpret_cast<const Complex*>(numbers.data());
  const FarGeometry geometry{static_cast<int>(count), given, given + count * length, errors.data(),
                             real.data(), paired.data(), static_cast<int>(starts.shape(0)),
                             reinterpret_cast<const Complex*>(origin.data()),
                             reinterpret_cast<const Complex*>(starts.data()), scale, tolerance, products};
  const std::size_t pairs = std::count(paired.data(), paired.data() + count, 1);
  const std::size_t poses = count + pairs, total = sets * poses;
  auto rotation = std::make_unique<Numbers[]>(total * 9);
  auto translation = std::make_unique<Numbers[]>(total * 3);
  auto quaternion = std::make_unique<Numbers[]>(total * 4);
  auto deviation = std::make_unique<double[]>(total);
  auto proved = std::make_unique<std::uint8_t[]>(total);
  auto complete = std::make_unique<std::uint8_t[]>(sets);
  DecideFar* const run = choose_build(build).decide;
  {
    nb::gil_scoped_release release;
    const std::size_t pieces = (sets + kTogether - 1) / kTogether;
    std::atomic<std::size_t> next{0};
    const auto work = [&] {
      std::vector<double> room(kFarRoom);
      for (std::size_t piece = next++; piece < pieces; piece = next++) {
        const std::size_t begin = piece * kTogether, size = std::min(kTogether, sets - begin), at = begin * poses;
        run(geometry,
            {static_cast<int>(size), shifts.data() + begin * kShifts * kEquations, units.data() + begin},
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

nb::tuple follow_far(Array<Numbers, 3> numbers, Array<Numbers, 1> from, Array<Numbers, 1> to,
                     Array<Numbers, 2> local, unsigned products, const std::string& build) {
  const std::size_t count = local.shape(0), seven = kLocal, length = numbers_of(products);
  require(numbers.shape(0) == 2 && numbers.shape(1) == count && numbers.shape(2) == length &&
              from.shape(0) == kEquations && to.shape(0) == kEquations && local.shape(1) == kLocal,
          "numbers, shifts and local must have shapes (2, count, 794 + 37 a product), (6,) and (count, 7)");
  const auto* given = reinterpret_cast<const Complex*>(numbers.data());
  const std::vector<double> errors(count);
  const std::vector<std::uint8_t> none(count);
  const FarGeometry geometry{static_cast<int>(count), given, given + count * length, errors.data(),
                             none.data(), none.data(), 0, nullptr, nullptr, 1.0, 1.0, products};
  auto reached = std::make_unique<Numbers[]>(count * kLocal);
  std::copy_n(local.data(), count * kLocal, reached.get());
  auto found = std::make_unique<std::uint8_t[]>(count);
  std::vector<double> room(kFarRoom);
  choose_build(build).follow(geometry, reinterpret_cast<const Complex*>(from.data()),
                             reinterpret_cast<const Complex*>(to.data()), room.data(),
                             reinterpret_cast<Complex*>(reached.get()), found.get());
  return nb::make_tuple(owned(std::move(reached), {count, seven}), owned(std::move(found), {count}));
}

}  // namespace

void bind_far_poses(nb::module_& m, FarBuild (*choose)(const std::string& build)) {
  choose_build = choose;
  m.def("decide_far", &decide_far, "numbers"_a, "errors"_a, "real"_a, "paired"_a, "origin"_a, "starts"_a,
        "shifts"_a, "units"_a, nb::kw_only(),
        "scale"_a, "tolerance"_a, "products"_a = 0, "jobs"_a = 1, "build"_a = "",
        "Prove poses far away in local coordinates; see gspcli.certification.poses.far_poses.");
  m.def("follow_far", &follow_far, "numbers"_a, "from_"_a, "to"_a, "local"_a, nb::kw_only(), "products"_a = 0,
        "build"_a = "",
        "Follow poses far away in local coordinates from one shift of the values to another.");
}

}  // namespace gsp
