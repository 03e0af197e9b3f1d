#include "ragdoll/graph.h"

#include <algorithm>  // min

namespace ragdoll {

Graph::Graph(int joint_count, std::span<const std::pair<int, int>> bars)
    : ends_(bars.begin(), bars.end()) {
  // count, then place: each joint's links keep the order of the bars
  begin_.assign(std::size_t(joint_count) + 1, 0);
  for (const auto& [p, q] : bars) {
    ++begin_[std::size_t(p) + 1];
    ++begin_[std::size_t(q) + 1];
  }
  for (std::size_t j = 0; j < std::size_t(joint_count); ++j) begin_[j + 1] += begin_[j];
  links_.resize(2 * bars.size());
  std::vector<int> cursor(begin_.begin(), begin_.end() - 1);
  for (std::size_t k = 0; k < bars.size(); ++k) {
    const auto [p, q] = bars[k];
    links_[std::size_t(cursor[std::size_t(p)]++)] = {int(k), q};
    links_[std::size_t(cursor[std::size_t(q)]++)] = {int(k), p};
  }
}

Components components_of(const Graph& graph) {
  Components components;
  components.of_joint.assign(std::size_t(graph.joint_count()), -1);
  std::vector<int> stack;
  for (int start = 0; start < graph.joint_count(); ++start) {
    if (components.of_joint[std::size_t(start)] >= 0) continue;
    const int id = components.count();
    components.lowest_joint.push_back(start);
    int joints = 0, link_ends = 0;
    components.of_joint[std::size_t(start)] = id;
    stack.push_back(start);
    while (!stack.empty()) {
      const int joint = stack.back();
      stack.pop_back();
      ++joints;
      for (const Graph::Link& link : graph.links(joint)) {
        ++link_ends;
        int& other = components.of_joint[std::size_t(link.other)];
        if (other >= 0) continue;
        other = id;
        stack.push_back(link.other);
      }
    }
    components.joint_count.push_back(joints);
    components.bar_count.push_back(link_ends / 2);
  }
  return components;
}

int cycle_rank(const Graph& graph, const Components& components) {
  return graph.bar_count() - graph.joint_count() + components.count();
}

std::string class_name(int cycle_rank) {
  if (cycle_rank == 0) return "tree";
  if (cycle_rank == 1) return "1-cycle";
  if (cycle_rank == 2) return "2-cycle";
  return "n-cycle";
}

std::string graph_class(const Components& components) {
  std::size_t largest = 0;
  for (std::size_t c = 1; c < components.joint_count.size(); ++c)
    if (components.joint_count[c] > components.joint_count[largest]) largest = c;
  return class_name(components.bar_count[largest] - components.joint_count[largest] + 1);
}

namespace {

/// Breadth-first search: the farthest joint (lowest index on ties), and every joint's parent.
int farthest_joint(const Graph& graph, int start, std::vector<int>& parent,
                   std::vector<int>& distance) {
  std::vector<int> queue = {start};
  distance[std::size_t(start)] = 0;
  parent[std::size_t(start)] = -1;
  for (std::size_t head = 0; head < queue.size(); ++head) {
    const int joint = queue[head];
    for (const Graph::Link& link : graph.links(joint)) {
      if (distance[std::size_t(link.other)] >= 0) continue;
      distance[std::size_t(link.other)] = distance[std::size_t(joint)] + 1;
      parent[std::size_t(link.other)] = joint;
      queue.push_back(link.other);
    }
  }
  int farthest = start;
  for (const int joint : queue) {
    const int d = distance[std::size_t(joint)], best = distance[std::size_t(farthest)];
    if (d > best || (d == best && joint < farthest)) farthest = joint;
  }
  // leave the scratch arrays clean but for the joints of this search
  for (const int joint : queue) distance[std::size_t(joint)] = -1;
  return farthest;
}

}  // namespace

MiddleJoint::MiddleJoint(const Graph& graph)
    : graph_(graph),
      parent_(std::size_t(graph.joint_count()), -1),
      distance_(std::size_t(graph.joint_count()), -1) {}

int MiddleJoint::of(int start) {
  const int one_end = farthest_joint(graph_, start, parent_, distance_);
  const int other_end = farthest_joint(graph_, one_end, parent_, distance_);
  std::vector<int> path;
  for (int joint = other_end; joint >= 0; joint = parent_[std::size_t(joint)])
    path.push_back(joint);
  // an even number of joints has two in the middle: the lower index
  const std::size_t half = path.size() / 2;
  return path.size() % 2 == 1 ? path[half] : std::min(path[half - 1], path[half]);
}

}  // namespace ragdoll
