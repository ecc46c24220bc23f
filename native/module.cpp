// Python bindings: arrays in, arrays out, the global interpreter lock released in between.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <complex>
#include <cstdlib>
#include <cstddef>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "bindings.hpp"
#include "modules.hpp"
#include "counting.hpp"
#include "homotopy.hpp"
#include "threads.hpp"
#include "tracker.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace gsp {
namespace {

using Points = nb::ndarray<const std::complex<double>, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Matrix = Points;
using Vector = nb::ndarray<const std::complex<double>, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Matrices =
    nb::ndarray<const std::complex<double>, nb::ndim<3>, nb::c_contig, nb::device::cpu>;

struct Build {
  const char* name;
  Track* track;
  Track* track_double_double;
  Track* track_short;
  TrackReal* track_real;
  Intersect* intersect;
  Count* count;
  Follow* follow;
  Decide* decide;
  FarBuild far;
  TrackValues* track_values;
};

constexpr Build kPortable{
    "portable",     track_portable,     track_portable_double_double,
    track_portable_short, track_portable_real, intersect_portable, count_portable,
    follow_portable, decide_portable,
    {decide_far_portable, follow_far_portable}, track_values_portable};
#if defined(GSP_X86)
constexpr Build kAvx2{
    "avx2",           track_avx2, track_avx2_double_double, track_avx2_short,
    track_avx2_real, intersect_avx2,   count_avx2, follow_avx2, decide_avx2,
    {decide_far_avx2, follow_far_avx2}, track_values_avx2};
constexpr Build kAvx512{
    "avx512",           track_avx512, track_avx512_double_double,
    track_avx512_short, track_avx512_real, intersect_avx512, count_avx512,      follow_avx512,
    decide_avx512, {decide_far_avx512, follow_far_avx512}, track_values_avx512};

bool has_avx2() { return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"); }
#endif

// The quickest build that this processor can run.
Build choose_build() {
#if defined(GSP_X86)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq"))
    return kAvx512;
  if (has_avx2()) return kAvx2;
#endif
  return kPortable;
}

// The environment variable that names the build for a whole process, to compare the output of builds.
constexpr const char* kVariable = "GSP_BUILD";

Build build_named(const std::string& name) {
  const Build best = choose_build();
  if (name.empty()) {
    const char* const wanted = std::getenv(kVariable);
    return wanted && *wanted ? build_named(wanted) : best;
  }
  if (name == best.name) return best;
  if (name == kPortable.name) return kPortable;
#if defined(GSP_X86)
  if (name == kAvx2.name && has_avx2()) return kAvx2;
#endif
  throw std::invalid_argument("this processor has no build named " + name);
}

nb::tuple track(nb::ndarray<const bool, nb::ndim<1>, nb::c_contig, nb::device::cpu> products,
                Matrix start_g, Matrix start_h, Vector start_tau, Matrices target_g,
                Matrices target_h, Matrix target_tau, Matrices more_g, Matrices more_h,
                Matrix more_tau, Points points, Matrices low_points,
                nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu> left,
                double predictor_tolerance, double contraction, double arrival, double radius_fraction, double min_step,
                double waypoint, double nearest, int max_steps, int late_steps, int digits,
                bool short_series,
                int jobs, const std::string& build) {
  const std::size_t targets = target_g.shape(0), paths = points.shape(0);
  require(products.shape(0) == kEquations && start_tau.shape(0) == kEquations, "six equations");
  require(start_g.shape(0) == kEquations && start_g.shape(1) == kCoefficients &&
              start_h.shape(0) == kEquations && start_h.shape(1) == kCoefficients,
          "start coefficients must have shape (6, 27)");
  require(target_g.shape(1) == kEquations && target_g.shape(2) == kCoefficients &&
              target_h.shape(0) == targets && target_h.shape(1) == kEquations &&
              target_h.shape(2) == kCoefficients && target_tau.shape(0) == targets &&
              target_tau.shape(1) == kEquations,
          "target coefficients must have shapes (targets, 6, 27), (targets, 6, 27), (targets, 6)");
  const std::size_t more_parts = more_g.shape(0);
  require((more_parts == 0 || (more_parts == kMore && targets == 1)) &&
              more_g.shape(1) == kEquations && more_g.shape(2) == kCoefficients &&
              more_h.shape(0) == more_parts && more_h.shape(1) == kEquations &&
              more_h.shape(2) == kCoefficients && more_tau.shape(0) == more_parts &&
              more_tau.shape(1) == kEquations,
          "what more digits add to one target must have shapes (1, 6, 27), (1, 6, 27), (1, 6)");
  require(low_points.shape(1) == kMore && low_points.shape(2) == kVariables &&
              (low_points.shape(0) == 0 || low_points.shape(0) == paths),
          "what is added to points must have shape (paths, 1, 8), or be of no paths");
  require(left.shape(0) == 0 || left.shape(0) == paths,
          "what is left of the way must have shape (paths,), or be of no paths");
  require(digits == 16 || digits == 32, "digits must be 16 or 32");
  const bool extended = digits > 16;
  require(points.shape(1) == kVariables, "points must have shape (paths, 8)");
  const Build chosen = build_named(build);
  Track* const run = extended ? chosen.track_double_double : short_series ? chosen.track_short : chosen.track;
  const Options options{predictor_tolerance, contraction, arrival, radius_fraction,
                        min_step,            waypoint,    nearest, max_steps,
                        late_steps};

  const std::size_t total = targets * paths;
  auto point = std::make_unique<std::complex<double>[]>(total * kVariables);
  auto low = std::make_unique<std::complex<double>[]>(extended ? total * kMore * kVariables : 0);
  auto remaining = std::make_unique<double[]>(total);
  auto status = std::make_unique<std::uint8_t[]>(total);
  auto steps = std::make_unique<std::int32_t[]>(total);
  auto condition = std::make_unique<double[]>(total);
  auto curvature = std::make_unique<double[]>(total);
  auto residual = std::make_unique<double[]>(total);
  auto correction = std::make_unique<double[]>(total);
  {
    nb::gil_scoped_release release;
    // Work is dealt out in pieces of one target's paths; long ones are cut for the threads' sake.
    const std::size_t piece = std::max<std::size_t>(64, (paths + 4 * jobs - 1) / (4 * jobs));
    const std::size_t pieces_each =
        jobs == 1 ? 1 : std::max<std::size_t>(1, (paths + piece - 1) / piece);
    const std::size_t length = (paths + pieces_each - 1) / std::max<std::size_t>(1, pieces_each);
    const std::size_t pieces = paths == 0 ? 0 : targets * pieces_each;
    std::atomic<std::size_t> next{0};
    const auto work = [&] {
      auto homotopy = std::make_unique<Homotopy>();
      auto real_homotopy = std::make_unique<RealHomotopy>();
      bool real = false;
      std::size_t prepared = targets;
      for (std::size_t i = next++; i < pieces; i = next++) {
        const std::size_t b = i / pieces_each, begin = (i % pieces_each) * length;
        if (begin >= paths) continue;
        const std::size_t count = std::min(length, paths - begin);
        if (prepared != b) {
          const std::size_t stride = kEquations * kCoefficients;
          const auto end = [&](const Matrices& g, const Matrices& h, const Matrix& tau,
                               std::size_t k) {
            return Side{g.data() + k * stride, h.data() + k * stride, tau.data() + k * kEquations};
          };
          Side more[kMore];
          for (std::size_t k = 0; k < more_parts; ++k) more[k] = end(more_g, more_h, more_tau, k);
          const Side from{start_g.data(), start_h.data(), start_tau.data()},
              to = end(target_g, target_h, target_tau, b);
          real = run == chosen.track_short &&
                 make_real_homotopy(products.data(), from, to, *real_homotopy);
          if (!real)
            make_homotopy(products.data(), from, to, more_parts ? more : nullptr, *homotopy);
          prepared = b;
        }
        const std::size_t at = b * paths + begin;
        const auto follow = [&](auto* way, const auto& equations) {
          way(equations, options, static_cast<int>(count),
              reinterpret_cast<const Complex*>(points.data() + begin * kVariables),
              low_points.shape(0) == 0 ? nullptr
                                       : reinterpret_cast<const Complex*>(low_points.data() +
                                                                          begin * kMore * kVariables),
              left.shape(0) == 0 ? nullptr : left.data() + begin,
              {reinterpret_cast<Complex*>(point.get() + at * kVariables),
               extended ? reinterpret_cast<Complex*>(low.get() + at * kMore * kVariables) : nullptr,
               remaining.get() + at, status.get() + at, steps.get() + at, condition.get() + at,
               curvature.get() + at, residual.get() + at, correction.get() + at});
        };
        if (real)
          follow(chosen.track_real, *real_homotopy);
        else
          follow(run, *homotopy);
      }
    };
    share(jobs, pieces, work);
  }
  const std::size_t eight = kVariables, one = kMore;
  return nb::make_tuple(owned(std::move(point), {targets, paths, eight}),
                        owned(std::move(low), {extended ? targets : 0, paths, one, eight}),
                        owned(std::move(remaining), {targets, paths}),
                        owned(std::move(status), {targets, paths}),
                        owned(std::move(steps), {targets, paths}),
                        owned(std::move(condition), {targets, paths}),
                        owned(std::move(curvature), {targets, paths}),
                        owned(std::move(residual), {targets, paths}),
                        owned(std::move(correction), {targets, paths}));
}

nb::tuple count(std::uint64_t prime, std::uint64_t seed, unsigned blocks,
                Array<std::int64_t, 3> hessians, Array<std::uint64_t, 2> moments,
                Array<std::uint64_t, 2> functions, Array<std::uint64_t, 2> squares,
                Array<std::uint64_t, 1> weights, Array<std::int64_t, 1> owners,
                std::size_t equations,
                const std::vector<std::vector<int>>& groups, bool find_distinct,
                std::uint64_t max_work, std::uint64_t max_entries, bool trace, bool moment_relations,
                const std::string& build) {
  const std::size_t width = kFunctions + moments.shape(0);
  require(prime % 2 == 1 && (prime < (1u << 30) || prime >> 60 == 1),
          "the prime must be odd and below 2^30 or between 2^60 and 2^61");
  require(prime > 2 * kFunctions, "the prime must not be small");
  require((blocks & (kTranslation | kBody)) != 0, "T or U must be among the coordinates");
  require(hessians.shape(0) == kFunctions && hessians.shape(1) == 8 && hessians.shape(2) == 8,
          "hessians must have shape (26, 8, 8)");
  require(moments.shape(1) == kFunctions && functions.shape(1) == width &&
              squares.shape(1) == width,
          "functions must have shapes (moments, 26), (equations, 26 + moments), (squares, same)");
  require(weights.shape(0) == squares.shape(0) && owners.shape(0) == squares.shape(0),
          "each square has a weight and an owner");
  require(equations <= functions.shape(0), "as many functions as equations at least");
  for (const std::vector<int>& group : groups)
    for (const int row : group)
      require(0 <= row && row < static_cast<int>(functions.shape(0)), "groups are of functions");
  const auto reduced = [&](const auto& array) {
    return std::all_of(array.data(), array.data() + array.size(),
                       [&](std::uint64_t x) { return x < prime; });
  };
  require(reduced(moments) && reduced(functions) && reduced(squares) && reduced(weights),
          "numbers must be reduced modulo the prime");
  for (std::size_t i = 0; i < squares.shape(0); ++i)
    require(std::all_of(&squares(i, 17), &squares(i, 17) + 9,
                        [](std::uint64_t x) { return x == 0; }),
            "T x R is squared by moments only");
  const auto interrupted = [] {
    nb::gil_scoped_acquire acquire;
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
  };
  Elimination elimination;
  const CountingProblem problem{prime,
                                seed,
                                blocks,
                                hessians.data(),
                                static_cast<int>(moments.shape(0)),
                                moments.data(),
                                static_cast<int>(equations),
                                functions.data(),
                                static_cast<int>(squares.shape(0)),
                                squares.data(),
                                weights.data(),
                                owners.data(),
                                moment_relations,
                                find_distinct,
                                groups,
                                max_work,
                                max_entries,
                                interrupted,
                                trace ? &elimination : nullptr};
  CountingResult result;
  {
    nb::gil_scoped_release release;
    result = build_named(build).count(problem);
  }
  nb::object followed = nb::none();
  if (trace) {
    nb::list steps;
    for (const EliminationStep& step : elimination.steps)
      steps.append(nb::make_tuple(step.degree, step.sources, step.pivots));
    followed = nb::make_tuple(elimination.variables, elimination.coordinates,
                              elimination.relations, elimination.quadrics, steps);
  }
  return nb::make_tuple(static_cast<int>(result.outcome), result.solutions, result.distinct,
                        result.apart, result.apart_distinct, result.falls, result.reach,
                        result.all_commutators, result.work, followed);
}

}  // namespace
}  // namespace gsp

NB_MODULE(_kernel, m) {
  m.doc() = "Native code of gspcli.continuation, gspcli.geometry and gspcli.certification.";
  m.def("track", &gsp::track, "products"_a, "start_g"_a, "start_h"_a, "start_tau"_a, "target_g"_a,
        "target_h"_a, "target_tau"_a, "more_g"_a, "more_h"_a, "more_tau"_a, "points"_a,
        "low_points"_a, "left"_a, nb::kw_only(), "predictor_tolerance"_a, "contraction"_a, "arrival"_a,
        "radius_fraction"_a, "min_step"_a, "waypoint"_a, "nearest"_a, "max_steps"_a, "late_steps"_a, "digits"_a,
        "short_series"_a, "jobs"_a, "build"_a = "",
        "Track every point from the start system to each target; see gspcli.continuation.tracker.");
  m.def("count", &gsp::count, "prime"_a, nb::kw_only(), "seed"_a, "blocks"_a, "hessians"_a,
        "moments"_a, "functions"_a, "squares"_a, "weights"_a, "owners"_a, "equations"_a, "groups"_a,
        "find_distinct"_a,
        "max_work"_a, "max_entries"_a, "trace"_a = false,
        "moment_relations"_a = true, "build"_a = "",
        "Count solutions modulo a prime; see gspcli.certification.counting.residue_counts.");
  gsp::bind_bodies(m);
  gsp::bind_closed_form(m, [](const std::string& name) { return gsp::build_named(name).intersect; });
  gsp::bind_ordering(m);
  gsp::bind_reach(m);
  gsp::bind_gaps(m);
  gsp::bind_controller(m);
  gsp::bind_branches(m, [](const std::string& name) { return gsp::build_named(name).follow; });
  gsp::bind_ends(m, [](const std::string& name) { return gsp::build_named(name).decide; });
  gsp::bind_far_poses(m, [](const std::string& name) { return gsp::build_named(name).far; });
  gsp::bind_reduced(m, [](const std::string& name) { return gsp::build_named(name).track_values; });
  m.def("build", [] { return gsp::build_named("").name; },
        "Name of the build that is used: avx512, avx2 or portable; the quickest that the processor "
        "runs, or that of the environment variable GSP_BUILD.");
}
