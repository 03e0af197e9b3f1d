// Aromatic hydrogens: which nitrogens of aromatic rings bear one, when only heavy atoms are known.
// Private to place_hydrogens.

#pragma once
#include <vector>

#include "ragdoll/molecule.h"  // Molecule

namespace ragdoll {

/// For each aromatic system that needs hydrogens on nitrogens with two neighbours, the sets of
/// nitrogens that could bear them: as few as leave a double bond to each other atom that takes one,
/// those beside a carbonyl first. Systems without such a need are left out.
std::vector<std::vector<std::vector<int>>> aromatic_hydrogen_sets(const Molecule& molecule);

}  // namespace ragdoll
