// The Python face of core's constraint options and of build_framework.

#pragma once
#include <nanobind/nanobind.h>

namespace ragdoll::bindings {

void bind_constraints(nanobind::module_& m);

}  // namespace ragdoll::bindings
