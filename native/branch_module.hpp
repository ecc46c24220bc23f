// The binding of branch_follower.hpp, for module.cpp.
#pragma once

#include <nanobind/nanobind.h>

#include <string>

#include "branch_follower.hpp"

namespace gsp {

// The build of a name; the best one for an empty name.
typedef Follow* ChooseFollow(const std::string&);

void bind_branches(nanobind::module_&, ChooseFollow*);

}  // namespace gsp
