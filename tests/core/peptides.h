// Peptides: chains of residues at given phi and psi, with heavy atoms alone or with hydrogens on N.
// Lengths in nm.

#pragma once
#include <vector>

#include "ragdoll/molecule.h"  // Molecule

namespace ragdoll::examples {

struct PhiPsi {
  double phi, psi;  ///< degrees
};

/// ACE, then alanines (or their mirror images) with these torsions, then NME. Each residue is N,
/// CA, C, O, CB; ACE is CH3, C, O (atoms 0-2), NME is N, CH3. Alanine k begins at atom 3 + 5 k.
Molecule alanines(const std::vector<PhiPsi>& torsions, bool mirrored = false);

/// Torsions of alanine k. degrees
PhiPsi torsions_of(const std::vector<Vec3>& positions, int alanine);

}  // namespace ragdoll::examples
