// Moved bars: which bars could be violated, because an end moved since they were last looked at.
// Lets a sweep leave the others out without changing its result. Private to the resolvers.

#pragma once
#include <algorithm>  // fill
#include <cstdint>
#include <vector>

#include "ragdoll/graph.h"  // Graph

namespace ragdoll {

template <class T>
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

  /// Keeps the positions, three numbers each, for move_changed.
  void remember(const T* x) { positions_.assign(x, x + 3 * std::size_t(graph_.joint_count())); }

  /// The joints that are not where remember() saw them have moved. All, if it saw none.
  void move_changed(const T* x) {
    if (positions_.empty()) {
      std::fill(moved_.begin(), moved_.end(), std::uint8_t(1));
      return;
    }
    for (std::size_t j = 0; j < positions_.size() / 3; ++j)
      if (x[3 * j] != positions_[3 * j] || x[3 * j + 1] != positions_[3 * j + 1] ||
          x[3 * j + 2] != positions_[3 * j + 2])
        move(int(j));
  }

 private:
  const Graph& graph_;
  std::vector<std::uint8_t> moved_;  ///< (nbar)
  std::vector<T> positions_;         ///< remembered (3 njoint)
};

}  // namespace ragdoll
