// Python bindings of branch_follower.hpp.
#include "modules.hpp"

#include <nanobind/stl/string.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "bindings.hpp"
#include "threads.hpp"
#include "branch_follower.hpp"

using namespace nanobind::literals;

namespace gsp {
namespace {

ChooseFollow* choose;

nb::tuple follow(Array<std::int32_t, 1> forms, Array<std::int32_t, 1> laws, Array<double, 1> signs,
                 Array<double, 1> largest, Array<double, 1> norms, Array<double, 4> hessians,
                 Array<double, 2> spectral, Array<double, 2> moduli, Array<double, 3> values,
                 Array<std::int64_t, 1> trajectory, Array<double, 2> start,
                 Array<double, 1> near, bool certify, int most_halvings, int jobs, const std::string& build) {
  constexpr std::size_t six = kConstraints, two = 2, eight = kCoordinates;
  const std::size_t count = start.shape(0), rows = values.shape(1);
  for (const auto& array : {signs, largest, norms})
    require(array.shape(0) == six, "six equations");
  require(forms.shape(0) == six && laws.shape(0) == six && hessians.shape(0) == six &&
              hessians.shape(1) == two && hessians.shape(2) == eight &&
              hessians.shape(3) == eight && spectral.shape(0) == six &&
              spectral.shape(1) == two && moduli.shape(0) == six && moduli.shape(1) == two,
          "equations must have shapes (6,), hessians (6, 2, 8, 8), their norms (6, 2)");
  require(values.shape(2) == six && rows > 0, "values must have shape (trajectories, rows, 6)");
  require(start.shape(1) == eight && trajectory.shape(0) == count && near.shape(0) == count,
          "start must have shape (branches, 8), trajectory and near (branches,)");
  MovingSystem system;
  for (std::size_t k = 0; k < six; ++k) {
    MovingEquation& q = system.equation[k];
    q.form = static_cast<Form>(forms.data()[k]);
    q.law = static_cast<Law>(laws.data()[k]);
    q.sign = signs.data()[k];
    q.largest = largest.data()[k];
    q.spectral = norms.data()[k];
    RealQuadric* quadrics[2] = {&q.a, &q.b};
    for (std::size_t j = 0; j < two; ++j) {
      const double* h = hessians.data() + (two * k + j) * eight * eight;
      std::copy(h, h + eight * eight, &quadrics[j]->hessian[0][0]);
      quadrics[j]->spectral = spectral.data()[two * k + j];
      quadrics[j]->moduli = moduli.data()[two * k + j];
    }
  }
  auto points = std::make_unique<double[]>(count * rows * eight);
  auto last = std::make_unique<double[]>(count * eight);
  auto previous = std::make_unique<double[]>(count * eight);
  auto fraction = std::make_unique<double[]>(count);
  auto worst = std::make_unique<double[]>(count);
  auto ends = std::make_unique<double[]>(count);
  auto alone = std::make_unique<double[]>(count);
  auto stop = std::make_unique<std::int32_t[]>(count);
  auto reached = std::make_unique<std::int32_t[]>(count);
  auto segments = std::make_unique<std::int64_t[]>(count);
  auto tries = std::make_unique<std::int64_t[]>(count);
  Follow* const run = choose(build);
  {
    nb::gil_scoped_release release;
    std::fill(points.get(), points.get() + count * rows * eight,
              std::numeric_limits<double>::quiet_NaN());
    std::vector<Branch> branches(count);
    for (std::size_t b = 0; b < count; ++b) {
      Branch& branch = branches[b];
      branch.values =
          values.data() + static_cast<std::size_t>(trajectory.data()[b]) * rows * six;
      branch.rows = static_cast<int>(rows);
      std::copy(start.data() + b * eight, start.data() + (b + 1) * eight, branch.start);
      branch.near = near.data()[b];
      branch.point = points.get() + b * rows * eight;
    }
    const std::size_t piece =
        jobs <= 1 ? std::max<std::size_t>(count, 1)
                  : std::max<std::size_t>(8, count / (4 * static_cast<std::size_t>(jobs)));
    std::atomic<std::size_t> next{0};
    const auto work = [&] {
      for (std::size_t begin = next.fetch_add(piece); begin < count;
           begin = next.fetch_add(piece))
        run(system, {certify, most_halvings}, branches.data() + begin,
            static_cast<int>(std::min(piece, count - begin)));
    };
    share(jobs, (count + piece - 1) / piece, work);
    for (std::size_t b = 0; b < count; ++b) {
      const Branch& branch = branches[b];
      std::copy(branch.last, branch.last + eight, last.get() + b * eight);
      std::copy(branch.previous, branch.previous + eight, previous.get() + b * eight);
      fraction[b] = branch.fraction;
      worst[b] = branch.worst;
      ends[b] = branch.near;
      alone[b] = branch.alone;
      stop[b] = static_cast<std::int32_t>(branch.stop);
      reached[b] = branch.reached;
      segments[b] = branch.segments;
      tries[b] = branch.tries;
    }
  }
  return nb::make_tuple(owned(std::move(points), {count, rows, eight}),
                        owned(std::move(stop), {count}), owned(std::move(reached), {count}),
                        owned(std::move(fraction), {count}), owned(std::move(last), {count, eight}),
                        owned(std::move(previous), {count, eight}),
                        owned(std::move(segments), {count}), owned(std::move(tries), {count}),
                        owned(std::move(worst), {count}), owned(std::move(ends), {count}),
                        owned(std::move(alone), {count}));
}

}  // namespace

void bind_branches(nb::module_& m, ChooseFollow* choose_follow) {
  choose = choose_follow;
  m.def("follow", &follow, "forms"_a, "laws"_a, "signs"_a, "largest"_a, "norms"_a, "hessians"_a,
        "spectral"_a, "moduli"_a, "values"_a, "trajectory"_a, "start"_a, "near"_a, nb::kw_only(),
        "certify"_a, "most_halvings"_a, "jobs"_a, "build"_a = "",
        "Follow real branches along trajectories of values; see gspcli.motion.following.branch_follower.");
}

}  // namespace gsp
