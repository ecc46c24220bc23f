// Python bindings of reduced_homotopy.hpp.
#pragma once

#include <nanobind/nanobind.h>

#include <string>

#include "reduced_homotopy.hpp"

namespace gsp {

void bind_reduced(nanobind::module_& m, TrackValues* (*choose)(const std::string& build));

}  // namespace gsp
