// Python bindings of gaps.hpp.
#pragma once

#include "bindings.hpp"

namespace gsp {

void bind_gaps(nb::module_& m);

}  // namespace gsp
