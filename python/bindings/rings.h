// The rings of molecules, for Python.

#pragma once
#include <nanobind/nanobind.h>

namespace ragdoll::bindings {
void bind_rings(nanobind::module_& m);
}  // namespace ragdoll::bindings
