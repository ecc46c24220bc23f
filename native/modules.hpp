// The parts of the Python module that have builds: `choose` gives that of a name, the best one for an
// empty name. The others are declared in bindings.hpp.
#pragma once

#include <nanobind/nanobind.h>

#include <string>

#include "bindings.hpp"
#include "branch_follower.hpp"
#include "ends.hpp"
#include "far_poses.hpp"
#include "intersection.hpp"
#include "reduced_homotopy.hpp"

namespace gsp {

typedef Follow* ChooseFollow(const std::string&);

void bind_branches(nanobind::module_&, ChooseFollow*);
void bind_closed_form(nanobind::module_& m, Intersect* (*choose)(const std::string& build));
void bind_ends(nanobind::module_& m, Decide* (*choose)(const std::string& build));
void bind_far_poses(nanobind::module_& m, FarBuild (*choose)(const std::string& build));
void bind_reduced(nanobind::module_& m, TrackValues* (*choose)(const std::string& build));

}  // namespace gsp
