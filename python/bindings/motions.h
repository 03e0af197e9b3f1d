// Motions: what moves walkers, as Python gives it.

#pragma once
#include <nanobind/nanobind.h>

namespace ragdoll::bindings {
void bind_motions(nanobind::module_& m);
}
