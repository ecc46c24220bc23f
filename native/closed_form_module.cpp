// Platforms with three angles, and the parts of their solution: arrays in, arrays out.
#include "modules.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <complex>
#include <optional>
#include <vector>

#include "bindings.hpp"
#include "closed_form.hpp"

using namespace nanobind::literals;

namespace gsp {
namespace {

using Number = std::complex<double>;

// The build of the intersections that has a name.
Intersect* (*choose)(const std::string& build);

// Points into the arrays, which must outlive it.
Measures measures_of(const Array<double, 3>& forms, int spheres, const std::vector<int>& skew,
                     const Array<double, 2>& signs, const std::optional<Array<double, 3>>& basis,
                     std::size_t squares) {
  const int k = static_cast<int>(signs.shape(1));
  require(0 <= spheres && spheres <= static_cast<int>(squares), "spheres must be among the squares");
  require(!basis || (basis->shape(0) == 3 && basis->shape(1) == 4 && basis->shape(2) == 4),
          "basis must have shape (3, 4, 4)");
  const Measures given{k,
                       spheres,
                       static_cast<int>(squares) - spheres,
                       static_cast<int>(skew.size()),
                       forms.data(),
                       skew.data(),
                       static_cast<int>(signs.shape(0)),
                       signs.data(),
                       basis ? basis->data() : nullptr};
  require(forms.shape(0) == static_cast<std::size_t>(given.forms()) && forms.shape(1) == 4 &&
              forms.shape(2) == 8,
          "there must be a form (4, 8) for each height, square, axis and normal");
  require(std::all_of(skew.begin(), skew.end(), [&](int i) { return 0 <= i && i < k; }),
          "moments must be among the heights");
  return given;
}

nb::tuple surfaces(Array<double, 3> forms, int spheres, std::vector<int> skew,
                   Array<double, 2> signs, std::optional<Array<double, 3>> basis,
                   Array<Number, 2> e, Array<double, 2> flat, Array<double, 2> curved) {
  const std::size_t rotations = e.shape(0), combinations = signs.shape(0), k = signs.shape(1);
  const std::size_t m = curved.shape(1), three = 3, four = 4;
  require(e.shape(1) == 4 && flat.shape(0) == rotations && flat.shape(1) == k &&
              curved.shape(0) == rotations,
          "e, flat and curved must have shapes (rotations, 4), (rotations, k), (rotations, m)");
  const Measures given = measures_of(forms, spheres, skew, signs, basis, m);
  const std::size_t planes = given.planes();
  const auto array = [&](std::size_t size) { return std::make_unique<Number[]>(rotations * size); };
  auto plane = array(combinations * planes * 4), quadric = array(m * 16), base = array(12);
  auto skewness = std::make_unique<double[]>(rotations);
  for (std::size_t r = 0; r < rotations; ++r)
    make_surfaces(given, e.data() + 4 * r, flat.data() + k * r, curved.data() + m * r,
                  {plane.get() + r * combinations * planes * 4, quadric.get() + r * m * 16,
                   base.get() + 12 * r, skewness.get() + r});
  return nb::make_tuple(owned(std::move(plane), {rotations, combinations, planes, four}),
                        owned(std::move(quadric), {rotations, m, four, four}),
                        owned(std::move(base), {rotations, four, three}),
                        owned(std::move(skewness), {rotations}));
}

nb::tuple intersect(Array<Number, 4> planes, Array<Number, 4> quadrics, Array<double, 1> accuracy,
                    Array<bool, 1> real, const std::string& build) {
  const std::size_t groups = planes.shape(0), systems = planes.shape(1), k = planes.shape(2);
  require(k <= 3 && planes.shape(3) == 4, "planes must have shape (groups, systems, k, 4)");
  require(quadrics.shape(0) == groups && quadrics.shape(1) == 3 - k && quadrics.shape(2) == 4 &&
              quadrics.shape(3) == 4,
          "quadrics must have shape (groups, 3 - k, 4, 4)");
  require(accuracy.shape(0) == groups && real.shape(0) == groups,
          "accuracy and real must have shape (groups,)");
  Intersect* const run = choose(build);
  const std::size_t total = groups * systems, each = std::size_t{8} >> k, four = 4;
  auto point = std::make_unique<Number[]>(total * each * four);
  auto error = std::make_unique<double[]>(total * each);
  auto ok = std::make_unique<bool[]>(total);
  {
    nb::gil_scoped_release release;
    run({static_cast<int>(groups), static_cast<int>(systems),
         reinterpret_cast<const Complex*>(planes.data()),
         reinterpret_cast<const Complex*>(quadrics.data()), accuracy.data(), real.data()},
        static_cast<int>(k), {reinterpret_cast<Complex*>(point.get()), error.get(), ok.get()});
  }
  return nb::make_tuple(owned(std::move(point), {groups, systems, each, four}),
                        owned(std::move(error), {groups, systems, each}),
                        owned(std::move(ok), {groups, systems}));
}

nb::tuple closed_forms(Array<double, 2> u, Array<double, 2> v, Array<double, 2> cosines,
                       Array<double, 3> forms, int spheres, std::vector<int> skew,
                       Array<double, 2> signs, std::optional<Array<double, 3>> basis,
                       Array<double, 2> flat, Array<double, 2> curved) {
  const std::size_t sets = cosines.shape(0), three = kAngles, eight = 8;
  require(u.shape(0) == three && u.shape(1) == 3 && v.shape(0) == three && v.shape(1) == 3,
          "u and v must have shape (3, 3)");
  require(cosines.shape(1) == three && flat.shape(0) == sets && curved.shape(0) == sets,
          "cosines, flat and curved must have shapes (sets, 3), (sets, k), (sets, m)");
  require(flat.shape(1) == signs.shape(1) && flat.shape(1) + curved.shape(1) == 3,
          "there must be three distances");
  const Measures given = measures_of(forms, spheres, skew, signs, basis, curved.shape(1));
  const std::size_t combinations = given.signs, poses = poses_of(given);
  auto point = std::make_unique<Number[]>(sets * combinations * poses * eight);
  auto general = std::make_unique<bool[]>(sets);
  {
    nb::gil_scoped_release release;
    solve_closed_forms({u.data(), v.data()}, given,
                       {static_cast<int>(sets), cosines.data(), flat.data(), curved.data()},
                       choose(""), point.get(), general.get());
  }
  return nb::make_tuple(owned(std::move(point), {sets, combinations, poses, eight}),
                        owned(std::move(general), {sets}));
}

}  // namespace

void bind_closed_form(nb::module_& m, Intersect* (*choose_intersect)(const std::string& build)) {
  choose = choose_intersect;
  m.def("surfaces", &surfaces, "forms"_a, "spheres"_a, "skew"_a, "signs"_a, "basis"_a.none(),
        "e"_a, "flat"_a, "curved"_a,
        "Return planes, quadrics, bases and skewness at rotations; see surfaces.hpp.");
  m.def("intersect", &intersect, "planes"_a, "quadrics"_a, "accuracy"_a, "real"_a, nb::kw_only(),
        "build"_a = "", "Return points, errors and what has been solved; see intersection.hpp.");
  m.def("closed_forms", &closed_forms, "u"_a, "v"_a, "cosines"_a, "forms"_a, "spheres"_a, "skew"_a,
        "signs"_a, "basis"_a.none(), "flat"_a, "curved"_a,
        "Return Study points of all poses, and which sets are in general position; see "
        "gspcli.geometry.three_angles.");
}

}  // namespace gsp
