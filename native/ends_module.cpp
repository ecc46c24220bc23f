#include "modules.hpp"

#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include <algorithm>
#include <atomic>
#include <complex>
#include <memory>
#include <tuple>
#include <vector>

#include "bindings.hpp"
#include "open_equations.hpp"
#include "threads.hpp"

using namespace nanobind::literals;

namespace gsp {
namespace {

using Numbers = std::complex<double>;

// Of each value: see OpenValues.
constexpr std::size_t kNumbers = 6;

Decide* (*choose)(const std::string& build);

void check_geometry(const Array<double, 3>& hessians, const Array<double, 3>& moduli,
                    const Array<std::int32_t, 2>& equations, const Array<std::int32_t, 1>& turned) {
  const std::size_t quadrics = hessians.shape(0), eight = kVariables, columns = 3;
  require(quadrics <= kMostQuadrics && hessians.shape(1) == eight && hessians.shape(2) == eight,
          "hessians must have shape (quadrics, 8, 8)");
  for (int axis = 0; axis < 3; ++axis)
    require(moduli.shape(axis) == hessians.shape(axis), "moduli must be shaped as hessians");
  require(equations.shape(0) == kEquations && equations.shape(1) == columns &&
              turned.shape(0) == kEquations,
          "equations and turned must have shapes (6, 3) and (6,)");
  const auto is_quadric = [&](std::int32_t k) { return k < static_cast<std::int32_t>(quadrics); };
  for (std::size_t r = 0; r < kEquations; ++r) {
    require(equations(r, 0) >= 0 && is_quadric(turned(r)), "equations must be made of the quadrics");
    for (std::size_t k = 0; k < columns; ++k)
      require(is_quadric(equations(r, k)), "equations must be made of the quadrics");
  }
}

nb::tuple decide(Array<double, 3> hessians, Array<double, 3> lows, Array<double, 3> moduli,
                 Array<std::int32_t, 2> equations, Array<double, 2> weights,
                 Array<std::int32_t, 1> turned, Array<double, 3> values,
                 Array<double, 1> units, Array<Numbers, 3> points, double unit, Array<double, 2> origins, double scale,
                 double tolerance, int jobs, const std::string& build) {
  const std::size_t systems = points.shape(0), count = points.shape(1);
  const std::size_t quadrics = hessians.shape(0), three = 3, four = 4, eight = kVariables;
  check_geometry(hessians, moduli, equations, turned);
  for (int axis = 0; axis < 3; ++axis)
    require(lows.shape(axis) == hessians.shape(axis), "lows must be shaped as hessians");
  require(weights.shape(0) == 4 && weights.shape(1) == kEquations && values.shape(0) == systems &&
              values.shape(1) == kNumbers && values.shape(2) == kEquations &&
              units.shape(0) == systems,
          "weights, values and units must have shapes (4, 6), (systems, 6, 6) and (systems,)");
  require(points.shape(2) == eight && origins.shape(0) == 2 && origins.shape(1) == 3,
          "points and origins must have shapes (systems, count, 8) and (2, 3)");
  ProofEquation equation[kEquations];
  for (std::size_t r = 0; r < kEquations; ++r)
    equation[r] = {equations(r, 0), {equations(r, 1), equations(r, 2)}};
  const OpenGeometry open{
      {static_cast<int>(quadrics), hessians.data(), moduli.data(), equation},
      weights.data(), weights.data() + kEquations, weights.data() + 2 * kEquations, turned.data(),
      unit, {origins(0, 0), origins(0, 1), origins(0, 2)},
      {origins(1, 0), origins(1, 1), origins(1, 2)}, scale, tolerance,
      lows.data(), weights.data() + 3 * kEquations};
  const std::size_t total = systems * count;
  auto rotation = std::make_unique<Numbers[]>(total * 9);
  auto translation = std::make_unique<Numbers[]>(total * 3);
  auto quaternion = std::make_unique<Numbers[]>(total * 4);
  auto deviation = std::make_unique<double[]>(total);
  auto proved = std::make_unique<std::uint8_t[]>(total);
  auto complete = std::make_unique<std::uint8_t[]>(systems);
  Decide* const run = choose(build);
  {
    nb::gil_scoped_release release;
    std::atomic<std::size_t> next{0};
    const auto work = [&] {
      std::vector<double> room(2 * quadrics * (eight * eight + kMonomials) + 3 * count);
      for (std::size_t s = next++; s < systems; s = next++) {
        const std::size_t at = s * count;
        const double* v = values.data() + s * kNumbers * kEquations;
        const OpenValues given{v, v + kEquations, v + 2 * kEquations, v + 3 * kEquations, v + 4 * kEquations,
                               v + 5 * kEquations, units(s)};
        const auto* const near = reinterpret_cast<const Complex*>(points.data() + at * eight);
        const Poses poses{reinterpret_cast<Complex*>(rotation.get() + at * 9),
                          reinterpret_cast<Complex*>(translation.get() + at * 3),
                          reinterpret_cast<Complex*>(quaternion.get() + at * 4), deviation.get() + at,
                          proved.get() + at, complete.get() + s};
        run(open, given, static_cast<int>(count), near, room.data(), poses);
      }
    };
    share(jobs, systems, work);
  }
  return nb::make_tuple(owned(std::move(rotation), {systems, count, three, three}),
                        owned(std::move(translation), {systems, count, three}),
                        owned(std::move(quaternion), {systems, count, four}),
                        owned(std::move(deviation), {systems, count}),
                        owned(std::move(proved), {systems, count}),
                        owned(std::move(complete), {systems}));
}

// Numbers (parts, constraints, points and directions, coordinates) as `Doubled`s.
nb::tuple open(Array<std::int32_t, 1> relations, Array<double, 4> numbers, Array<double, 3> tables,
               double tiny) {
  const std::size_t parts = 3, vectors = 4, coordinates = 3, eight = kVariables;
  require(relations.shape(0) == kEquations && numbers.shape(0) == parts &&
              numbers.shape(1) == kEquations && numbers.shape(2) == vectors &&
              numbers.shape(3) == coordinates && tables.shape(0) == kStudyForms &&
              tables.shape(1) == eight && tables.shape(2) == eight,
          "relations, numbers and tables must have shapes (6,), (3, 6, 4, 3) and (27, 8, 8)");
  Primitives constraints[kEquations];
  for (std::size_t i = 0; i < kEquations; ++i) {
    Primitives& p = constraints[i];
    require(relations(i) >= 0 && relations(i) <= static_cast<std::int32_t>(Relation::kMeetingLines),
            "no such relation");
    p.relation = static_cast<Relation>(relations(i));
    Doubled* const vector[] = {p.a, p.b, p.u, p.v};
    for (std::size_t k = 0; k < vectors; ++k)
      for (std::size_t j = 0; j < coordinates; ++j)
        vector[k][j] = {numbers(0, i, k, j), numbers(1, i, k, j), numbers(2, i, k, j)};
  }
  const std::size_t size = eight * eight, columns = 3, rows = 4, six = kEquations;
  auto hessian = std::make_unique<double[]>(kMostQuadrics * size);
  auto low = std::make_unique<double[]>(kMostQuadrics * size);
  auto moduli = std::make_unique<double[]>(kMostQuadrics * size);
  auto weights = std::make_unique<double[]>(rows * six);
  auto table = std::make_unique<std::int32_t[]>(columns * six);
  auto turned = std::make_unique<std::int32_t[]>(six);
  double* const w = weights.get();
  OpenEquations out{0, hessian.get(), low.get(), moduli.get(), w, w + six, w + 2 * six, w + 3 * six,
                    table.get(), turned.get()};
  open_equations(constraints, tables.data(), tiny, out);
  const std::size_t quadrics = out.quadrics;
  return nb::make_tuple(owned(std::move(hessian), {quadrics, eight, eight}),
                        owned(std::move(low), {quadrics, eight, eight}),
                        owned(std::move(moduli), {quadrics, eight, eight}),
                        owned(std::move(table), {six, columns}),
                        owned(std::move(weights), {rows, six}), owned(std::move(turned), {six}));
}

}  // namespace

void bind_ends(nb::module_& m, Decide* (*choose_decide)(const std::string& build)) {
  choose = choose_decide;
  m.def("open", &open, "relations"_a, "numbers"_a, "tables"_a, nb::kw_only(), "tiny"_a,
        "Write down equations with their values left open; see gspcli.certification.poses.many_values.");
  m.def("decide", &decide, "hessians"_a, "lows"_a, "moduli"_a, "equations"_a, "weights"_a, "turned"_a,
        "values"_a, "units"_a, "points"_a, nb::kw_only(), "unit"_a, "origins"_a, "scale"_a, "tolerance"_a,
        "jobs"_a = 1, "build"_a = "",
        "Prove what ends of paths are poses; see gspcli.certification.poses.many_values.");
}

}  // namespace gsp
