// Python bindings of ends.hpp.
#pragma once

#include <nanobind/nanobind.h>

#include <string>

#include "ends.hpp"

namespace gsp {

void bind_ends(nanobind::module_& m, Decide* (*choose)(const std::string& build));

}  // namespace gsp
