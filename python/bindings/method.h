// The parts of module _core that are bound in files of their own.

#pragma once
#include <nanobind/nanobind.h>

namespace ragdoll::bindings {

void bind_method_tools(nanobind::module_& m);

}  // namespace ragdoll::bindings
