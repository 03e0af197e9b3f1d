// DiverseChoice: few conformers that stand for many. Private to core.

#pragma once
#include <functional>
#include <span>
#include <vector>

#include "lane_rmsd.h"  // ConformerBlock

namespace ragdoll {

/// RMSD with symmetry: least over permutations of places.
class SymmetricRmsd {
 public:
  SymmetricRmsd(const ConformerBlock& block, const std::vector<std::vector<int>>& permutations)
      : block_(block),
        permutations_(permutations),
        plain_(3 * block.atom_count()),
        permuted_(3 * block.atom_count()) {}

  /// Shortens distances of all conformers from `first` on (see ConformerBlock::shorten) to one.
  void shorten(std::size_t conformer, std::size_t first, std::span<float> distances) {
    shorten(conformer, block_, first, distances);
  }

  /// The same for the conformers of another block.
  void shorten(std::size_t conformer, const ConformerBlock& others, std::size_t first,
               std::span<float> distances);

 private:
  const ConformerBlock& block_;
  const std::vector<std::vector<int>>& permutations_;
  std::vector<float> plain_, permuted_;
};

/// Conformers of a block whose mean distance to the nearest one chosen is small, where each counts
/// by its weight: seeds far from each other, then, in each cluster around one, the member nearest
/// to the others, a few times over (k-medoids, by Lloyd's alternation).
/// @param fixed  those that are chosen already, come first in the result
std::vector<int> choose_diverse(const ConformerBlock& block,
                                const std::vector<std::vector<int>>& permutations,
                                std::span<const float> weights, int count, int rounds);

}  // namespace ragdoll
