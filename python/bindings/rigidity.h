// The rigidity part of module _core.

#pragma once
#include <nanobind/nanobind.h>

namespace ragdoll::bindings {

void bind_rigidity(nanobind::module_& m);

}  // namespace ragdoll::bindings
