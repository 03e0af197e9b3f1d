// Breadth first: a traversal of the graph that tells its visits one at a time, so that who needs
// only the first of them pays for no more. Private to core.

#pragma once
#include <vector>

#include "ragdoll/graph.h"  // Graph
#include "ragdoll/order.h"  // Visit

namespace ragdoll {

/// A problem constraint is visited when the second of its ends is taken off the queue, at its place
/// among that joint's bars.
class BreadthFirst {
 public:
  explicit BreadthFirst(const Graph& graph)
      : graph_(graph),
        depth_(std::size_t(graph.joint_count()), -1),
        taken_(std::size_t(graph.joint_count()), 0),
        used_(std::size_t(graph.bar_count()), 0) {}

  bool reached(int joint) const { return depth_[std::size_t(joint)] >= 0; }

  /// Starts from a joint that was not reached yet, behind what was entered before.
  void enter(int joint) {
    depth_[std::size_t(joint)] = 0;
    queue_.push_back(joint);
  }

  /// The caller visits the bar himself.
  void leave_out(int bar) { used_[std::size_t(bar)] = 1; }

  /// @return false where all that can be reached from what was entered is visited
  bool next(Visit& visit) {
    for (; head_ < queue_.size(); ++head_, link_ = 0) {
      const int joint = queue_[head_];
      taken_[std::size_t(joint)] = 1;
      const auto links = graph_.links(joint);
      while (link_ < links.size()) {
        const Graph::Link link = links[link_++];
        if (used_[std::size_t(link.bar)]) continue;
        if (!reached(link.other)) {
          used_[std::size_t(link.bar)] = 1;
          depth_[std::size_t(link.other)] = depth_[std::size_t(joint)] + 1;
          queue_.push_back(link.other);
          visit = {link.bar, joint, link.other, false};
          return true;
        }
        if (taken_[std::size_t(link.other)]) {
          used_[std::size_t(link.bar)] = 1;
          visit = problem_visit(graph_, link, joint, depth_);
          return true;
        }
      }
    }
    return false;
  }

  /// Forgets all visits; costs no more than they did.
  void start_over() {
    for (const int joint : queue_) {
      depth_[std::size_t(joint)] = -1;
      taken_[std::size_t(joint)] = 0;
      for (const Graph::Link& link : graph_.links(joint)) used_[std::size_t(link.bar)] = 0;
    }
    queue_.clear();
    head_ = link_ = 0;
  }

  /// The nearer end has the smaller depth; at one depth it is left to the caller's bar order.
  static Visit problem_visit(const Graph& graph, const Graph::Link& link, int joint,
                             const std::vector<int>& depth) {
    const int here = depth[std::size_t(joint)], there = depth[std::size_t(link.other)];
    const auto [first, second] = graph.ends(link.bar);
    if (there == here) return {link.bar, first, second, true};
    if (there < here) return {link.bar, link.other, joint, true};
    return {link.bar, joint, link.other, true};
  }

 private:
  const Graph& graph_;
  std::vector<int> depth_;            ///< -1: not reached (njoint)
  std::vector<unsigned char> taken_;  ///< taken off the queue (njoint)
  std::vector<unsigned char> used_;   ///< visited (nbar)
  std::vector<int> queue_;
  std::size_t head_ = 0, link_ = 0;  ///< the joint that is taken, the next of its bars
};

}  // namespace ragdoll
