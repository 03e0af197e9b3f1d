// Moved bars: which bars could be violated, because an end moved since they were last looked at.
// Lets a sweep leave the others out without changing its result. Private to the resolvers.

#pragma once
#include <algorithm>  // fill
#include <cstdint>
#include <span>
#include <vector>

#include "ragdoll/graph.h"  // Graph
#include "ragdoll/vec3.h"   // Vec3

namespace ragdoll {

class MovedBars {
 public:
  explicit MovedBars(const Graph& graph)
      : graph_(graph), moved_(std::size_t(graph.bar_count()), 1) {}

  bool has(int bar) const { return moved_[std::size_t(bar)] != 0; }

  /// The bar is within tolerance where its ends are now.
  void settle(int bar) { moved_[std::size_t(bar)] = 0; }

  /// A joint moved: all its bars could be violated.
  void move(int joint) {
    for (const Graph::Link& link : graph_.links(joint)) moved_[std::size_t(link.bar)] = 1;
  }

  /// Keeps the positions, for move_changed.
  void remember(std::span<const Vec3> positions) {
    positions_.assign(positions.begin(), positions.end());
  }

  /// The joints that are not where remember() saw them have moved. All, if it saw none.
  void move_changed(std::span<const Vec3> positions) {
    if (positions_.size() != positions.size()) {
      std::fill(moved_.begin(), moved_.end(), std::uint8_t(1));
      return;
    }
    for (std::size_t j = 0; j < positions.size(); ++j)
      if (positions[j] != positions_[j]) move(int(j));
  }

 private:
  const Graph& graph_;
  std::vector<std::uint8_t> moved_;  ///< (nbar)
  std::vector<Vec3> positions_;      ///< remembered (njoint)
};

}  // namespace ragdoll
