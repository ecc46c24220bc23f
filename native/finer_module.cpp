#include "finer_module.hpp"

#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include <complex>
#include <memory>
#include <vector>

#include "bindings.hpp"

using namespace nanobind::literals;

namespace gsp {
namespace {

using Numbers = std::complex<double>;

DecideFiner* (*choose)(const std::string& build);

nb::tuple decide_finer(Array<double, 3> coefficients, Array<double, 2> bounds, Array<std::int32_t, 2> equations,
                       Array<Numbers, 3> points, double unit, Array<double, 2> origins, double scale, double tolerance, const std::string& build) {
  const std::size_t parts = points.shape(0), count = points.shape(1), eight = kVariables, six = kEquations;
  const std::size_t quadrics = coefficients.shape(1), three = 3, four = 4, columns = 3;
  require(coefficients.shape(0) == four && quadrics <= kMostQuadrics && coefficients.shape(2) == kMonomials &&
              bounds.shape(0) == quadrics && bounds.shape(1) == kMonomials,
          "coefficients and bounds must have shapes (4, quadrics, 27) and (quadrics, 27)");
  require(equations.shape(0) == six && equations.shape(1) == columns, "equations must have the shape (6, 3)");
  require(parts >= 1 && parts <= four && points.shape(2) == eight && origins.shape(0) == 2 && origins.shape(1) == 3,
          "points and origins must have shapes (parts, count, 8) and (2, 3)");
  const auto is_quadric = [&](std::int32_t k) { return k < static_cast<std::int32_t>(quadrics); };
  ProofEquation equation[kEquations];
  for (std::size_t r = 0; r < six; ++r) {
    require(equations(r, 0) >= 0, "equations must be made of the quadrics");
    for (std::size_t k = 0; k < columns; ++k)
      require(is_quadric(equations(r, k)), "equations must be made of the quadrics");
    equation[r] = {equations(r, 0), {equations(r, 1), equations(r, 2)}};
  }
  const FinerPlatform platform{
      {static_cast<int>(quadrics), coefficients.data(), equation},
      bounds.data(),
      {unit, {origins(0, 0), origins(0, 1), origins(0, 2)}, {origins(1, 0), origins(1, 1), origins(1, 2)}},
      scale, tolerance};
  auto rotation = std::make_unique<Numbers[]>(count * 9);
  auto translation = std::make_unique<Numbers[]>(count * 3);
  auto quaternion = std::make_unique<Numbers[]>(count * 4);
  auto deviation = std::make_unique<double[]>(count);
  auto proved = std::make_unique<std::uint8_t[]>(count);
  auto reached = std::make_unique<Numbers[]>(four * count * eight);
  DecideFiner* const run = choose(build);
  {
    nb::gil_scoped_release release;
    std::vector<double> room(quadrics * eight * eight);
    run(platform, static_cast<int>(parts), static_cast<int>(count),
        reinterpret_cast<const Complex*>(points.data()), room.data(),
        {reinterpret_cast<Complex*>(rotation.get()), reinterpret_cast<Complex*>(translation.get()),
         reinterpret_cast<Complex*>(quaternion.get()), deviation.get(), proved.get(),
         reinterpret_cast<Complex*>(reached.get())});
  }
  return nb::make_tuple(owned(std::move(rotation), {count, three, three}),
                        owned(std::move(translation), {count, three}),
                        owned(std::move(quaternion), {count, four}), owned(std::move(deviation), {count}),
                        owned(std::move(proved), {count}), owned(std::move(reached), {four, count, eight}));
}

}  // namespace

void bind_finer_ends(nb::module_& m, DecideFiner* (*choose_decide)(const std::string& build)) {
  choose = choose_decide;
  m.def("decide_finer", &decide_finer, "coefficients"_a, "bounds"_a, "equations"_a, "points"_a, nb::kw_only(), "unit"_a, "origins"_a, "scale"_a, "tolerance"_a, "build"_a = "",
        "Prove poses with 64 digits; see gspcli.certification.poses.finer_proofs.");
}

}  // namespace gsp
