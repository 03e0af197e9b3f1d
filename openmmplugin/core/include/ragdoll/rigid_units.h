// Rigid units: joints of a framework whose distances are all bars, with the shape that these give.

#pragma once
#include <vector>

#include "ragdoll/framework.h"  // Framework
#include "ragdoll/vec3.h"       // Vec3

namespace ragdoll {

/// A set of joints that turns and moves as one body.
struct RigidUnit {
  std::vector<int> joints;
  std::vector<Vec3> shape;   ///< nm, about its centre (njoint of the unit)
  bool either_hand = false;  ///< nothing tells the shape from its mirror image
};

/// Units that hold every bar at least once: a centre and its neighbours, a peptide unit, a single
/// bar where it has no angles. Each bar that no unit holds yet grows one, by joints that are barred
/// to all of it; shapes come from the lengths (classical scaling), hands from the volumes. Units
/// share joints; where they do, hinges are.
/// @param largest  joints of a unit at most, 2 or more
std::vector<RigidUnit> find_rigid_units(const Framework& framework, int largest = 24);

}  // namespace ragdoll
