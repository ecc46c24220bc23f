#include "controller_module.hpp"

#include <algorithm>
#include <memory>

#include "bindings.hpp"
#include "controller.hpp"

namespace gsp {
namespace {

using namespace nb::literals;
using Bytes = Array<unsigned char, 1>;
using Doubles = Array<double, 1>;

nb::ndarray<nb::numpy, double> copied(const double* from, std::size_t count) {
  auto data = std::make_unique<double[]>(count);
  std::copy(from, from + count, data.get());
  return owned(std::move(data), {count});
}

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

nb::object jacobian(const Controller& self) {
  auto data = std::make_unique<double[]>(36);
  if (self.jacobian(data.get())) return nb::none();
  return nb::cast(owned(std::move(data), {6, 6}));
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
      .def("jacobian", &jacobian)
      .def("report", &report)
      .def("position", [](const Controller& self) { return copied(self.position(), 3); })
      .def("rotation", [](const Controller& self) { return copied(self.rotation(), 4); })
      .def("values", [](const Controller& self) { return copied(self.values(), 6); })
      .def("error", &Controller::error);
}

}  // namespace gsp
