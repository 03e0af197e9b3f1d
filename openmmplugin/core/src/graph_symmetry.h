// GraphSymmetry: which heavy atoms of a molecule can take each other's places. Private to core.

#pragma once
#include <vector>

#include "ragdoll/molecule.h"  // Molecule

namespace ragdoll {

/// Permutations of a molecule's heavy atoms (of all, where there is none) that keep its bond graph.
/// Elements tell atoms apart, and how many hydrogens and which kinds of bonds they have; the two
/// ends of a carboxylate, a nitro group or a phosphate are alike, charged or not. Chirality is not
/// looked at: what is no symmetry in space is far in RMSD.
class GraphSymmetry {
 public:
  /// @param most  permutations that are listed; those that exchange equal ends of one atom, which
  ///              are many in tert-butyl groups, are varied first
  GraphSymmetry(const Molecule& molecule, std::size_t most);

  /// Atoms that are compared, ascending. (n)
  const std::vector<int>& atoms() const { return atoms_; }

  /// For each permutation the place of each atom's image in atoms(); the first changes nothing.
  const std::vector<std::vector<int>>& permutations() const { return permutations_; }

  /// Whether the list is complete.
  bool complete() const { return complete_; }

  /// Places in atoms() of equal ends on one atom, two or more of each: oxygens of a carboxylate,
  /// fluorines of CF3, methyls of isopropyl.
  const std::vector<std::vector<int>>& equal_ends() const { return equal_ends_; }

 private:
  std::vector<int> atoms_;
  std::vector<std::vector<int>> permutations_, equal_ends_;
  bool complete_ = true;
};

}  // namespace ragdoll
