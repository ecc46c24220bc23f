// Python bindings of reach.hpp.
#pragma once

#include "bindings.hpp"

namespace gsp {

void bind_reach(nb::module_& m);

}  // namespace gsp
