// Conformers of small molecules, for Python.

#pragma once
#include <nanobind/nanobind.h>

namespace ragdoll::bindings {
void bind_conformers(nanobind::module_& m);
}
