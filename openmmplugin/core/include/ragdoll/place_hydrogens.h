// Place hydrogens: those of N, O and S of a molecule that has none, to find hydrogen bonds by.

#pragma once
#include "ragdoll/molecule.h"  // Molecule

namespace ragdoll {

/// The molecule with hydrogens on N, O and S after its own atoms, as many as bond orders and
/// charges leave room for. Where they follow from the heavy atoms they are put there (amides,
/// guanidinium, rings); hydrogens that turn (OH, SH, NH3+) are turned to where their hydrogen bonds
/// are strongest, or are staggered, and an imidazole has its one on the nitrogen where it bonds
/// more strongly. Parts (whatever bonds join) that have a hydrogen on N, O or S are left as they
/// are, as are atoms with bonds of unknown order, and waters, whose hydrogens could be anywhere.
Molecule place_hydrogens(const Molecule& molecule);

}  // namespace ragdoll
