// Hydrophobic tethers: pairs of non-polar carbons and sulfurs that touch.

#pragma once
#include <vector>

#include "ragdoll/molecule.h"  // Molecule

namespace ragdoll {

struct HydrophobicTether {
  int a = 0, b = 0;     ///< atoms, the lower first
  double distance = 0;  ///< nm, in the molecule
  double bound = 0;     ///< nm; sum of van der Waals radii and the margin
};

struct HydrophobicTetherOptions {
  double margin = 0.05;    ///< nm; how far apart the surfaces of two atoms may be
  double shortest = 0.22;  ///< nm; closer pairs are not taken
};

/// Pairs of C or S that are bonded to nothing but C, S and H, and more than three bonds apart. In
/// the order of their atoms.
/// @throw Error  an option that is not a number
std::vector<HydrophobicTether> hydrophobic_tethers(const Molecule& molecule,
                                                   const HydrophobicTetherOptions& options = {});

}  // namespace ragdoll
