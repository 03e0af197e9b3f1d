// Sweep order: which order the passes of `ordered` follow, from one break and one pass to the next.
// Private to the resolvers.

#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "breadth_first.h"     // BreadthFirst
#include "ragdoll/random.h"    // Random
#include "ragdoll/resolver.h"  // ResolverSettings, Breakage

namespace ragdoll {

class SweepOrder {
 public:
  SweepOrder(const Framework& framework, const ResolverSettings& settings);

  /// Whether it changes from pass to pass.
  bool changes() const;

  /// Whether the order can be told visit by visit, outward from the roots.
  bool by_visit() const;

  /// Whether the visits are made once more after that, backwards.
  bool and_back() const { return by_visit() && kind_ == OrderKind::bfs_reverse; }

  /// Starts such an order. @return false if it is that of the break before, as far as it was told
  bool start(std::span<const int> roots);

  /// Its next visit. @return false where it ends
  bool next(Visit& visit);

  /// The order of a break's first pass. @return false if it is that of the break before
  bool prepare(std::span<const int> roots, Random& random, Order& order);

  /// The order of the next pass, where orders change.
  /// @param problem_bar  the problem constraint corrected last in the pass before; -1: none
  /// @param worst_bar    the bar that is violated most; -1: none
  /// @return false if it stays
  bool change(int problem_bar, int worst_bar, Random& random, Order& order);

  /// Whether the error of a visited bar is shared evenly, whatever the weighting.
  bool even(const Visit& visit);

 private:
  const std::vector<int>& middle_joints();
  bool enter_next_component();
  bool in_dense_block(int bar);

  const Framework& framework_;
  OrderKind kind_;
  Order custom_order_;  ///< replaces kind_ where it is not empty
  std::vector<int> roots_, middle_joints_;
  bool ready_ = false;

  // told visit by visit
  std::optional<BreadthFirst> steps_;
  int next_component_ = 0;    ///< that is entered where it was not reached
  std::vector<int> root_of_;  ///< of several roots, the first in each component; -1 (ncomponent)

  std::vector<std::uint8_t> dense_;  ///< in a dense cycle block (nbar), where it is asked for
};

}  // namespace ragdoll
