#pragma once

#include <nanobind/nanobind.h>

namespace gsp {

void bind_ordering(nanobind::module_& m);

}  // namespace gsp
