// Random start: positions of a molecule from its bonds alone, by resolving joints from random
// places.

#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "ragdoll/framework.h"  // Framework, Volume
#include "ragdoll/molecule.h"   // Molecule
#include "ragdoll/vec3.h"       // Vec3

namespace ragdoll {

/// What is known of the distance of two atoms. One length where the bounds are equal.
struct DistanceBounds {
  int p = 0, q = 0;
  double lower = 0, upper = 0;  ///< nm
};

/// A framework from ideal values instead of positions, which the molecule's are not looked at for:
/// bounds of distances across bonds, angles and planar units, volumes, and contacts by radii
/// between atoms that are more than three bonds apart and have no bounds.
/// @throw Error  as Framework does; on bounds that are out of order
Framework ideal_framework(const Molecule& molecule, std::span<const DistanceBounds> distances,
                          std::span<const Volume> volumes, double contact_scale);

struct RandomStartSettings {
  std::uint64_t seed = 0;
  double tolerance = 5e-3;  ///< relative
  int attempts = 20;        ///< random places that are tried
};

struct RandomStart {
  std::vector<Vec3> positions;  ///< nm (njoint); empty: no attempt was resolved
  int attempts = 0;             ///< how many were made
};

/// Joints at random, resolved by `newton`: first without the contact rule, so that the molecule
/// finds its shape through itself; then what is too near is pushed apart and resolved again and
/// again; at the end with the rule. What is not resolved within the tolerance, or has a centre
/// inside out, is tried again from other places.
/// @throw Error  on settings that make no sense
RandomStart random_start(const Framework& framework, const RandomStartSettings& settings = {});

}  // namespace ragdoll
