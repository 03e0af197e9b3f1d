// CommonFramework: what holds two conformations of one molecule, so that a path between them is not
// blocked by what only one of them has.

#pragma once
#include <span>
#include <vector>

#include "ragdoll/box.h"        // Box
#include "ragdoll/framework.h"  // Framework
#include "ragdoll/vec3.h"       // Vec3

namespace ragdoll {

/// How many bounds of a framework the second conformation has, has nearly, and does not have.
struct CommonBounds {
  int kept = 0, widened = 0, dropped = 0;
};

/// The framework less the tethers, contacts and bounds of planar units that the second conformation
/// does not have; what it has nearly is widened to let it in. Bars and chirality stay. Where all
/// joints are known, pairs may be as close as the second conformation has them, but for heavy atoms
/// that overlap there; contacts of hydrogens are softer, so that side chains pass each other. Where
/// the place of a joint is not known, the nearest joint along the bonds that has one tells how its
/// distances change.
/// @param start   the framework's own conformation, nm (njoint)
/// @param joints  that are known of the second one (n)
/// @param other   where these are, nm (n)
/// @param margin  bounds missed by no more are widened, nm
/// @param bounds  what became of them; may be null
/// @param box     for contacts by minimum image; null: no periodic box
/// @throw Error on sizes that disagree, or a joint that is none
Framework common_framework(const Framework& framework, std::span<const Vec3> start,
                           std::span<const int> joints, std::span<const Vec3> other,
                           double margin = 0.03, CommonBounds* bounds = nullptr,
                           const Box* box = nullptr);

/// For each joint the index of the nearest of `joints` along the bonds; -1: none is bonded to it.
std::vector<int> nearest_along_bonds(const Framework& framework, std::span<const int> joints);

}  // namespace ragdoll
