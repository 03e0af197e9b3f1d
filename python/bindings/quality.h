// The Python face of quality.

#pragma once
#include <nanobind/nanobind.h>

namespace ragdoll::bindings {

void bind_quality(nanobind::module_& m);

}  // namespace ragdoll::bindings
