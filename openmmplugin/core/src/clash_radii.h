// Radii of atoms for the counting of clashes.

#pragma once
#include "ragdoll/molecule.h"  // Molecule

namespace ragdoll {

/// Of heavy atoms among themselves, nm; 0 for hydrogens and metals, which take no part.
double heavy_clash_radius(int element);

/// Of an atom among all atoms, as in MolProbity's all-atom contacts (hydrogens at their nuclei),
/// nm; 0 for metals.
double all_atom_clash_radius(const Molecule& molecule, int atom);

/// A hydrogen on N, O or S.
bool is_polar_hydrogen(const Molecule& molecule, int atom);

/// N, O or S that may take a hydrogen bond.
bool is_acceptor(const Molecule& molecule, int atom);

}  // namespace ragdoll
