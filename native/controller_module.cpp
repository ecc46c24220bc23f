#include <algorithm>
#include <memory>

#include "bindings.hpp"
#include "controller.hpp"

namespace gsp {
namespace {

using namespace nb::literals;
using Bytes = Array<unsigned char, 1>;
using Doubles = Array<double, 1>;

void make(Controller* self, const Bytes& kind, const Bytes& either, const Doubles& numbers) {
  require(kind.shape(0) == 6 && either.shape(0) == 6, "kind and either must have shape (6,)");
  require(numbers.shape(0) == Controller::kNumbers, "numbers has a wrong length");
  new (self) Controller(kind.data(), either.data(), numbers.data());
}

int start(Controller& self, const Doubles& pose) {
  require(pose.shape(0) == 7, "pose must have shape (7,)");
  return self.start(pose.data());
}

int forward(Controller& self, const Doubles& values) {
  require(values.shape(0) == 6, "values must have shape (6,)");
  return self.forward(values.data());
}

void limit(Controller& self, const Doubles& numbers, const Bytes& legs, const Bytes& on_base, bool still) {
  require(numbers.shape(0) == Controller::kLimits, "numbers has a wrong length");
  require(legs.shape(0) <= Controller::kMostCones && on_base.shape(0) == legs.shape(0),
          "legs and on_base must have the same shape, (12,) at most");
  self.limit(numbers.data(), legs.shape(0), legs.data(), on_base.data(), still);
}

int nearest(Controller& self, const Doubles& pose) {
  require(pose.shape(0) == 7, "pose must have shape (7,)");
  return self.nearest(pose.data());
}

nb::object seek(const Controller& self, const Doubles& goal, const Doubles& start) {
  require(goal.shape(0) == 7 && start.shape(0) == 7, "poses must have shape (7,)");
  double pose[7];
  std::copy(start.data(), start.data() + 7, pose);
  const double distance = self.seek(goal.data(), pose);
  if (distance < 0.0) return nb::none();
  return nb::make_tuple(distance, copied(pose, 7));
}

nb::tuple slack(const Controller& self, const Doubles& pose) {
  require(pose.shape(0) == 7, "pose must have shape (7,)");
  double room[Controller::kMostSlacks], rows[6 * Controller::kMostSlacks];
  const std::size_t count = self.slack(pose.data(), room, rows);
  auto data = std::make_unique<double[]>(6 * count);
  std::copy(rows, rows + 6 * count, data.get());
  return nb::make_tuple(copied(room, count), owned(std::move(data), {count, 6}));
}

nb::object jacobian(const Controller& self) {
  auto data = std::make_unique<double[]>(36);
  if (self.jacobian(data.get())) return nb::none();
  return nb::cast(owned(std::move(data), {6, 6}));
}

nb::tuple follow_rows(const Controller& self, const Array<double, 2>& values, const Doubles& pose,
                      double near, double shortest, int tries, bool keep) {
  require(values.shape(0) > 0 && values.shape(1) == 6, "values must have shape (r, 6)");
  require(pose.shape(0) == 7, "pose must have shape (7,)");
  const FollowedRows found =
      self.follow_rows(values.data(), values.shape(0), pose.data(), {near, shortest, tries, keep});
  const auto table = [](const std::vector<double>& from, std::size_t width) {
    auto data = std::make_unique<double[]>(from.size());
    std::copy(from.begin(), from.end(), data.get());
    return owned(std::move(data), {from.size() / width, width});
  };
  return nb::make_tuple(found.reached, table(found.poses, 7), copied(found.last, 7), found.fraction,
                        found.error, found.alone, found.steps, found.tries, found.worst,
                        table(found.pieces, FollowedRows::kPiece));
}

nb::tuple report(const Controller& self) {
  const StepReport r = self.report();
  return nb::make_tuple(r.fraction, r.sigma, r.alone, r.steps, r.tries);
}

}  // namespace

void bind_controller(nb::module_& m) {
  nb::class_<Controller>(m, "Controller", "See gspcli.motion.following.follower.")
      .def("__init__", &make, "kind"_a, "either"_a, "numbers"_a)
      .def("start", &start, "pose"_a)
      .def("forward", &forward, "values"_a)
      .def("limit", &limit, "numbers"_a, "legs"_a, "on_base"_a, "still"_a)
      .def("nearest", &nearest, "pose"_a)
      .def("seek", &seek, "goal"_a, "start"_a)
      .def("slack", &slack, "pose"_a)
      .def("jacobian", &jacobian)
      .def("follow_rows", &follow_rows, "values"_a, "pose"_a, "near"_a, "shortest"_a, "tries"_a,
           "keep"_a)
      .def("report", &report)
      .def("position", [](const Controller& self) { return copied(self.position(), 3); })
      .def("rotation", [](const Controller& self) { return copied(self.rotation(), 4); })
      .def("values", [](const Controller& self) { return copied(self.values(), 6); })
      .def("error", &Controller::error);
}

}  // namespace gsp
