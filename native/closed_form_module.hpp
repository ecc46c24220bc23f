// Python bindings of closed_form.hpp and of its parts.
#pragma once

#include <nanobind/nanobind.h>

#include <string>

#include "intersection.hpp"

namespace gsp {

void bind_closed_form(nanobind::module_& m, Intersect* (*choose)(const std::string& build));

}  // namespace gsp
