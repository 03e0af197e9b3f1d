// NewtonRange: which tethers and contacts are rows of the pattern of `newton`: those whose ends are
// few bars apart. Private to the solver `newton`.

#pragma once
#include <cstddef>
#include <limits>  // max
#include <vector>

#include "ragdoll/framework.h"  // Framework

namespace ragdoll {

class NewtonRange {
 public:
  static constexpr int anywhere = std::numeric_limits<int>::max();

  explicit NewtonRange(const Framework& framework);

  /// @param bars  between the ends of a pair that is covered; -1: none are whose ends both move
  void set_reach(int bars) { reach_ = bars; }
  bool covers_tether(std::size_t k) const { return apart_[k] <= reach_; }
  bool covers_contact(std::size_t k) const { return apart_[tethers_ + k] <= reach_; }

 private:
  std::size_t tethers_;
  /// Bars between the ends, of tethers, then of contacts; those that are further apart than it
  /// matters are `anywhere`, those that have a fixed end, and so no block, -1.
  std::vector<int> apart_;
  int reach_ = anywhere;
};

}  // namespace ragdoll
