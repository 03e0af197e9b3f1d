// Stacked rings: flat rings that lie on each other.

#pragma once
#include <utility>  // pair
#include <vector>

#include "ragdoll/molecule.h"  // Molecule

namespace ragdoll {

struct StackedRingOptions {
  double distance = 0.55;    ///< nm; the most between the centres of two rings
  double angle_degree = 30;  ///< the most between their planes
  double margin = 0.05;      ///< nm; how far apart the surfaces of two atoms may be
};

/// Two atoms of two stacked rings that face each other.
struct StackedPair {
  int a = 0, b = 0;     ///< atoms, the lower first
  double distance = 0;  ///< nm, in the molecule
  double bound = 0;  ///< nm; sum of van der Waals radii and the margin, or the distance if larger
};

/// Aromatic rings of five and six atoms that are not fused, with centres near each other and planes
/// nearly parallel, one above the other; of each two, three pairs of atoms that are nearest. In the
/// order of their atoms, each pair once.
/// @throw Error  an option that is not a number
std::vector<StackedPair> stacked_rings(const Molecule& molecule,
                                       const StackedRingOptions& options = {});

}  // namespace ragdoll
