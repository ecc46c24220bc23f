// Bindings of the step of a controller.
#pragma once

#include <nanobind/nanobind.h>

namespace gsp {

void bind_controller(nanobind::module_& m);

}  // namespace gsp
