// The binding of tubes.hpp, for module.cpp.
#pragma once

#include <nanobind/nanobind.h>

#include <string>

#include "tubes.hpp"

namespace gsp {

// The build of a name; the best one for an empty name.
typedef Follow* ChooseFollow(const std::string&);

void bind_tubes(nanobind::module_&, ChooseFollow*);

}  // namespace gsp
