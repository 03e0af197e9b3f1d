// Ring systems: the atoms of a molecule that close rings, those of fused, bridged and spiro rings
// together.

#pragma once
#include <vector>

#include "ragdoll/molecule.h"  // Molecule

namespace ragdoll {

struct RingSystem {
  std::vector<int> atoms;      ///< ascending
  std::vector<int> bonds;      ///< of Molecule::bonds, ascending
  std::vector<int> ring_size;  ///< atoms of the smallest ring through each of these bonds

  int largest_ring() const;  ///< the largest of ring_size
};

/// In the order of their lowest atoms. Dative bonds close no rings: what coordinates a metal is not
/// a ring for that.
std::vector<RingSystem> ring_systems(const Molecule& molecule);

}  // namespace ragdoll
