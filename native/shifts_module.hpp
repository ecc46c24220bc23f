// Python bindings of shifts.hpp.
#pragma once

#include <nanobind/nanobind.h>

#include <string>

#include "shifts.hpp"

namespace gsp {

void bind_shifts(nanobind::module_& m, TrackShifts* (*choose)(const std::string& build));

}  // namespace gsp
