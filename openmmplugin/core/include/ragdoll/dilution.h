// Dilution: the rigidity of a network at every number of its last bonds, in one pass.

#pragma once
#include <utility>
#include <vector>

#include "ragdoll/rigidity.h"  // BodyBarNetwork, Rigidity

namespace ragdoll {

/// Bonds from the first removable one on come in turn. Bars only make clusters grow, so that one
/// list of merges holds the clusters of every level.
class Dilution {
 public:
  /// @throw Error  as analyse_rigidity, or no such number of fixed bonds
  Dilution(BodyBarNetwork network, int fixed_bonds);

  /// Level k has the fixed bonds and the first k removable ones.
  int level_count() const { return int(cluster_merges_at_.size()); }

  /// What analyse_rigidity gives for the network of that level.
  Rigidity at(int level) const;

  /// Bodies that all searches looked at: the cost, in a unit that no machine changes.
  long visits() const { return visits_; }

 private:
  using Merges = std::vector<std::pair<int, int>>;
  std::vector<bool> leaf_bonds(int bonds) const;

  BodyBarNetwork network_;
  int fixed_bonds_;
  std::vector<int> independent_bars_;           ///< (nbond)
  Merges cluster_merges_, region_merges_;       ///< pairs of bodies, in turn
  std::vector<std::size_t> cluster_merges_at_;  ///< how many by each level (nlevel)
  std::vector<std::size_t> region_merges_at_;
  long visits_ = 0;
};

}  // namespace ragdoll
