// Python bindings of far_poses.hpp.
#pragma once

#include <nanobind/nanobind.h>

#include <string>

#include "far_poses.hpp"

namespace gsp {

void bind_far_poses(nanobind::module_& m, FarBuild (*choose)(const std::string& build));

}  // namespace gsp
