// Python bindings of finer_ends.hpp.
#pragma once

#include <nanobind/nanobind.h>

#include <string>

#include "finer_ends.hpp"

namespace gsp {

void bind_finer_ends(nanobind::module_& m, DecideFiner* (*choose)(const std::string& build));

}  // namespace gsp
