// ConstraintOptions: which constraints beside the covalent ones hold a framework.

#pragma once
#include <cstdint>
#include <vector>

#include "ragdoll/framework.h"            // Bar, Tether, Contact
#include "ragdoll/hydrogen_bonds.h"       // HydrogenBondOptions
#include "ragdoll/hydrophobic_tethers.h"  // HydrophobicTetherOptions
#include "ragdoll/stacked_rings.h"        // StackedRingOptions
#include "ragdoll/vec3.h"                 // Vec3

namespace ragdoll {

/// How far phi and psi may go from where they start.
enum class TorsionRegion : std::uint8_t {
  basin = 0,   ///< a residue stays in its own part of the map: helix, strand or left-handed helix
  joined = 1,  ///< helix and strand are joined by the bridge between them
};

struct ConstraintOptions {
  bool hydrogen_bonds = true;  ///< and salt bridges
  HydrogenBondOptions hydrogen_bond = {};
  /// Of the room that the criteria of a hydrogen bond leave between hydrogen and acceptor, the
  /// share that they may use; the rest is what its angles may use.
  double hydrogen_bond_room = 0.5;
  bool place_hydrogens = true;          ///< for finding hydrogen bonds, where a molecule has none
  bool solvent_hydrogen_bonds = false;  ///< those of waters

  bool hydrophobic = true;
  HydrophobicTetherOptions hydrophobic_tether = {};

  bool stacking = true;
  StackedRingOptions stacked_ring = {};

  bool metals = true;         ///< bars from metals to the N, O and S that coordinate them
  double metal_slack = 0.05;  ///< nm that these may be longer than the sum of covalent radii
  /// Further bonds of metals, of any element and length, such as a file records; their lengths are
  /// those of the input.
  std::vector<Bar> coordination = {};

  bool torsion_basins = true;  ///< of phi and psi
  TorsionRegion torsion_region = TorsionRegion::basin;
  bool staggered = true;        ///< bonds of side chains stay off the eclipsed positions
  double eclipsed_degree = 20;  ///< how near to them they may come

  /// Further positions of the atoms, nm, that all this has to allow, such as where a path leads:
  /// bounds are wide enough for them, and what one of them does not have is not held.
  std::vector<std::vector<Vec3>> conformations = {};

  // the user's own
  std::vector<Bar> bars = {};  ///< a length of 0: the present distance
  std::vector<Tether> tethers = {};
  std::vector<Contact> contacts = {};
  std::vector<int> fixed = {};  ///< joints that do not move
};

}  // namespace ragdoll
