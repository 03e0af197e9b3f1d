// Superposition: root mean square deviation after the best rotation and translation.

#pragma once
#include <span>

#include "ragdoll/vec3.h"  // Vec3

namespace ragdoll {

/// Least RMSD of two sets of points over all rotations and translations (Horn, J. Opt. Soc.
/// Am. A 4, 629, 1987). nm
/// @throw Error if the sets are empty or differ in size
double superposed_rmsd(std::span<const Vec3> a, std::span<const Vec3> b);

}  // namespace ragdoll
