// Pliant rings: how much of a framework gives way where rings change their shape. Private to core.

#pragma once
#include <span>
#include <vector>

#include "chemistry_rules.h"       // PlanarUnits
#include "ragdoll/framework.h"     // FrameworkParts
#include "ragdoll/molecule.h"      // Molecule
#include "ragdoll/ring_systems.h"  // RingSystem

namespace ragdoll {

/// What of a molecule's ring systems gives way.
class PliantRings {
 public:
  PliantRings(const Molecule& molecule, std::span<const RingSystem> systems);

  const PlanarUnits& units() const { return units_; }
  bool in_ring(int bond) const { return in_ring_[std::size_t(bond)]; }
  /// A bond of a ring that may turn.
  bool turns(int bond) const { return in_ring(bond) && !units_.planar_bond(bond); }
  /// The angle between two bonds that meet: at an atom of a ring, not both planar.
  bool gives(int bond, int other) const {
    return (in_ring(bond) || in_ring(other)) &&
           !(units_.planar_bond(bond) && units_.planar_bond(other));
  }
  /// A nitrogen that may turn inside out: in one ring, not of three, with one neighbour beside it.
  bool inverts(int atom) const { return inverts_[std::size_t(atom)]; }

  /// Bars that give way become bounds, and the volumes that rings do without are left out. Angles
  /// play about the mean of those that are alike, which a shape distorts less than its own.
  /// @param play  of angles, rad
  FrameworkParts loosen(const FrameworkParts& parts, double play) const;

 private:
  bool is_left_out(const Volume& volume) const;

  const Molecule& molecule_;
  PlanarUnits units_;
  std::vector<unsigned char> in_ring_, inverts_;  ///< (nbond), (natom)
};

}  // namespace ragdoll
