// Torsion bounds: phi and psi in their basins, and side chains off the eclipsed positions, as
// distances. Private to build_framework.

#pragma once
#include <vector>

#include "chemistry_rules.h"             // PlanarUnits
#include "conformations.h"               // Conformations
#include "noncovalent.h"                 // BoundList
#include "ragdoll/constraint_options.h"  // TorsionRegion
#include "ragdoll/molecule.h"            // Molecule

namespace ragdoll {

/// An alpha amino acid between two peptide bonds, with a side chain. Atoms
struct BackboneResidue {
  int alpha_before, carbon_before, oxygen_before;  ///< of the peptide bond before
  int nitrogen, alpha, beta, carbon, oxygen;
  int nitrogen_after, alpha_after;
  bool is_proline;      ///< its N and side chain are a ring
  bool before_proline;  ///< the N after it has three heavy neighbours
};

/// Found by bonds alone, whatever residues are called; glycine is not among them.
std::vector<BackboneResidue> backbone_residues(const Molecule& molecule, const PlanarUnits& units);

/// Each residue's phi and psi stay in the part of the map where it is in one of the conformations,
/// or near which it is: six distances or so between atoms of the two peptide units and the beta
/// carbon, each within what the part allows with this residue's own bond lengths and angles. A
/// residue that starts elsewhere has bounds that reach as far. D residues have the mirrored map.
void hold_backbone(const Molecule& molecule, const PlanarUnits& units, TorsionRegion region,
                   const Conformations& conformations, BoundList& bounds);

/// Heavy atoms across a bond between two tetrahedral atoms, but in small rings, come no nearer than
/// with a torsion of `eclipsed_degree`.
void hold_staggered(const Molecule& molecule, const PlanarUnits& units, double eclipsed_degree,
                    const Conformations& conformations, BoundList& bounds);

}  // namespace ragdoll
