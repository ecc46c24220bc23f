#pragma once

#include <nanobind/nanobind.h>

namespace gsp {

void bind_bodies(nanobind::module_& m);

}  // namespace gsp
