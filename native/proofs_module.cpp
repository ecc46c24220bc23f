#include "proofs_module.hpp"

#include <nanobind/stl/string.h>

#include <atomic>
#include <complex>
#include <memory>

#include "bindings.hpp"
#include "digits.hpp"
#include "threads.hpp"

using namespace nanobind::literals;

namespace gsp {
namespace {

Prove* (*choose)(const std::string& build);

nb::tuple prove(Array<double, 4> hessians, Array<double, 4> moduli,
                Array<std::int32_t, 2> equations, Array<std::complex<double>, 3> points,
                Array<std::int32_t, 2> patches, int jobs, const std::string& build) {
  const std::size_t systems = points.shape(0), count = points.shape(1);
  const std::size_t quadrics = hessians.shape(1), eight = kVariables, columns = 3;
  require(hessians.shape(0) == systems && hessians.shape(2) == eight &&
              hessians.shape(3) == eight && quadrics <= kMostQuadrics,
          "hessians must have shape (systems, quadrics, 8, 8)");
  for (int axis = 0; axis < 4; ++axis)
    require(moduli.shape(axis) == hessians.shape(axis), "moduli must be shaped as hessians");
  require(equations.shape(0) == kEquations && equations.shape(1) == columns,
          "equations must have shape (6, 3)");
  require(points.shape(2) == eight && patches.shape(0) == systems && patches.shape(1) == count,
          "points and patches must have shapes (systems, count, 8) and (systems, count)");
  ProofEquation equation[kEquations];
  for (int r = 0; r < kEquations; ++r) {
    const std::int32_t* row = equations.data() + columns * r;
    equation[r] = {row[0], {row[1], row[2]}};
    for (std::size_t k = 0; k < columns; ++k)
      require(row[k] < static_cast<std::int32_t>(quadrics) && (k > 0 || row[k] >= 0),
              "equations must be made of the quadrics");
  }
  for (std::size_t p = 0; p < systems * count; ++p)
    require(patches.data()[p] >= 0 && patches.data()[p] < 4, "patches must be from 0 to 3");
  auto point = std::make_unique<std::complex<double>[]>(systems * count * eight);
  auto error = std::make_unique<double[]>(systems * count);
  auto proved = std::make_unique<std::uint8_t[]>(systems * count);
  Prove* const run = choose(build);
  {
    nb::gil_scoped_release release;
    std::atomic<std::size_t> next{0};
    const auto work = [&] {
      for (std::size_t s = next++; s < systems; s = next++) {
        const std::size_t at = s * count, of = s * quadrics * eight * eight;
        run({static_cast<int>(quadrics), hessians.data() + of, moduli.data() + of, equation},
            static_cast<int>(count), reinterpret_cast<const Complex*>(points.data() + at * eight),
            patches.data() + at,
            {reinterpret_cast<Complex*>(point.get() + at * eight), error.get() + at,
             proved.get() + at});
      }
    };
    share(jobs, systems, work);
  }
  return nb::make_tuple(owned(std::move(point), {systems, count, eight}),
                        owned(std::move(error), {systems, count}),
                        owned(std::move(proved), {systems, count}));
}

nb::tuple prove_digits(Array<std::uint64_t, 3> numbers, Array<double, 3> table,
                       Array<std::complex<double>, 3> points, double error, double unit,
                       Array<double, 2> origins) {
  const std::size_t forms = table.shape(0), count = points.shape(0), parts = points.shape(1);
  const std::size_t eight = kVariables, rows = kEquations + 1;
  require(table.shape(1) == eight && table.shape(2) == eight, "table must have shape (k, 8, 8)");
  require(numbers.shape(0) == rows && numbers.shape(1) == forms && numbers.shape(2) == kDigitWords,
          "numbers must have shape (7, k, 7)");
  require(points.shape(2) == eight, "points must have shape (n, parts, 8)");
  require(origins.shape(0) == 2 && origins.shape(1) == 3, "origins must have shape (2, 3)");
  auto R = std::make_unique<std::complex<double>[]>(count * 9);
  auto T = std::make_unique<std::complex<double>[]>(count * 3);
  auto quaternion = std::make_unique<std::complex<double>[]>(count * 4);
  auto norm = std::make_unique<std::complex<double>[]>(count);
  auto proved = std::make_unique<std::uint8_t[]>(count);
  const auto plain = [](std::unique_ptr<std::complex<double>[]>& array) {
    return reinterpret_cast<Complex*>(array.get());
  };
  {
    nb::gil_scoped_release release;
    prove_with_digits({static_cast<int>(forms), table.data(), numbers.data(), error, unit,
                       origins.data(), origins.data() + 3},
                      static_cast<int>(count), static_cast<int>(parts),
                      reinterpret_cast<const Complex*>(points.data()),
                      {plain(R), plain(T), plain(quaternion), plain(norm), proved.get()});
  }
  return nb::make_tuple(owned(std::move(R), {count, 3, 3}), owned(std::move(T), {count, 3}),
                        owned(std::move(quaternion), {count, 4}), owned(std::move(norm), {count}),
                        owned(std::move(proved), {count}));
}

}  // namespace

void bind_proofs(nb::module_& m, Prove* (*choose_prove)(const std::string& build)) {
  choose = choose_prove;
  m.def("prove", &prove, "hessians"_a, "moduli"_a, "equations"_a, "points"_a, "patches"_a,
        nb::kw_only(), "jobs"_a = 1, "build"_a = "",
        "Prove that single solutions are near points; see gspcli.certification.poses.many_values.");
  m.def("prove_digits", &prove_digits, "numbers"_a, "table"_a, "points"_a, nb::kw_only(),
        "error"_a, "unit"_a, "origins"_a,
        "Prove that single solutions of quadrics are near points, with 86 digits; see "
        "gspcli.certification.poses.digit_proofs.");
}

}  // namespace gsp
