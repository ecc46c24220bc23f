// Python bindings of proofs.hpp.
#pragma once

#include <nanobind/nanobind.h>

#include <string>

#include "proofs.hpp"

namespace gsp {

void bind_proofs(nanobind::module_& m, Prove* (*choose)(const std::string& build));

}  // namespace gsp
