// Graph: joints and the bars they meet, and what the thesis asks of it: components, cycle rank,
// class, and the middle joint from which a component is resolved.

#pragma once
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace ragdoll {

/// Adjacency in insertion order: a joint meets its bars in the order in which they were added.
class Graph {
 public:
  struct Link {
    int bar, other;  ///< index of the bar, joint at its other end
  };

  Graph() = default;
  Graph(int joint_count, std::span<const std::pair<int, int>> bars);

  int joint_count() const { return int(begin_.size()) - 1; }
  int bar_count() const { return int(ends_.size()); }

  /// First and second joint of a bar.
  std::pair<int, int> ends(int bar) const { return ends_[std::size_t(bar)]; }

  /// The bars that a joint meets.
  std::span<const Link> links(int joint) const {
    return {links_.data() + begin_[std::size_t(joint)],
            links_.data() + begin_[std::size_t(joint) + 1]};
  }

 private:
  std::vector<int> begin_ = {0};           ///< (njoint + 1)
  std::vector<Link> links_;                ///< (2 nbar)
  std::vector<std::pair<int, int>> ends_;  ///< (nbar)
};

/// Components in the order of their lowest joints.
struct Components {
  std::vector<int> of_joint;      ///< (njoint)
  std::vector<int> lowest_joint;  ///< (ncomponent)
  std::vector<int> joint_count;   ///< (ncomponent)
  std::vector<int> bar_count;     ///< (ncomponent)
  int count() const { return int(lowest_joint.size()); }
};

Components components_of(const Graph& graph);

/// Bars - joints + components: the number of independent cycles.
int cycle_rank(const Graph& graph, const Components& components);

/// "tree", "1-cycle", "2-cycle" or "n-cycle", by the cycle rank of the component.
std::string class_name(int cycle_rank);

/// Class of the largest component (most joints; the first of them on ties).
std::string graph_class(const Components& components);

/// The middle joint of a component: of the path that two breadth-first searches find, from `start`,
/// then from the farthest joint; the lowest index on ties. O(joints + bars of the component).
class MiddleJoint {
 public:
  explicit MiddleJoint(const Graph& graph);
  int of(int start);

 private:
  const Graph& graph_;
  std::vector<int> parent_, distance_;  ///< scratch (njoint)
};

}  // namespace ragdoll
