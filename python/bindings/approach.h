// Approach: paths towards a second conformation.

#pragma once
#include <nanobind/nanobind.h>

namespace ragdoll::bindings {
void bind_approach(nanobind::module_& m);
}
