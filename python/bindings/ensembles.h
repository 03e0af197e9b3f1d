// The Python face of ensembles and walkers.

#pragma once
#include <nanobind/nanobind.h>

namespace ragdoll::bindings {

void bind_ensembles(nanobind::module_& m);

}  // namespace ragdoll::bindings
