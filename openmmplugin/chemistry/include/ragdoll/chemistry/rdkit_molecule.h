// RDKit's molecules as core sees them, and core's positions as conformers of RDKit's.

#pragma once
#include <span>
#include <string>
#include <vector>

#include "ragdoll/molecule.h"  // Molecule, Vec3

namespace RDKit {
class ROMol;
}

namespace ragdoll {

/// Atoms, bonds, orders, charges and one conformer of an RDKit molecule, its explicit atoms alone.
/// Bonds are sorted by their atoms. Python's `Molecule.from_rdkit` makes the same of the same
/// molecule.
/// @param conformer  its id; -1 is the first
/// @throw Error  if there is no such conformer, it is flat, a coordinate is no usable number, or an
///               atom has no element
Molecule molecule_from_rdkit(const RDKit::ROMol& mol, int conformer = -1);

/// The title of the molecule, or `otherwise` where it has none.
std::string title_of(const RDKit::ROMol& mol, const std::string& otherwise = "The molecule");

/// Whether the molecule has a conformer in three dimensions.
bool has_places(const RDKit::ROMol& mol);

/// Adds positions (natom), nm, as a conformer. @return its id
unsigned int add_conformer(RDKit::ROMol& mol, std::span<const Vec3> positions);

}  // namespace ragdoll
