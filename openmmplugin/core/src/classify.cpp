#include "ragdoll/classify.h"

#include <algorithm>  // sort, unique, min, any_of
#include <utility>    // pair, move

namespace ragdoll {
namespace {

/// Blocks by Hopcroft & Tarjan (1973): a depth-first search with an explicit stack of joints, and
/// the bars met so far on another. low = the earliest joint that a subtree's bars reach.
class BlockSearch {
 public:
  explicit BlockSearch(const Graph& graph)
      : graph_(graph),
        found_(std::size_t(graph.joint_count()), -1),
        low_(std::size_t(graph.joint_count()), -1),
        joined_(std::size_t(graph.joint_count()), 0) {}

  void search(int root) {
    discover(root, -1);
    int blocks_at_root = 0;
    while (!path_.empty()) {
      Step& step = path_.back();
      const auto links = graph_.links(step.joint);
      if (step.next < links.size()) {
        follow(step.joint, step.bar, links[step.next++]);
        continue;
      }
      // a joint is done: hand its low to its parent, and cut off what hangs on the parent only
      const Step done = step;
      path_.pop_back();
      if (path_.empty()) break;
      const int parent = path_.back().joint;
      int& low = low_[std::size_t(parent)];
      low = std::min(low, low_[std::size_t(done.joint)]);
      if (low_[std::size_t(done.joint)] < found_[std::size_t(parent)]) continue;
      cut(done.bar);
      if (parent != root || ++blocks_at_root == 2) joined_[std::size_t(parent)] = 1;
    }
  }

  std::vector<int> bridges;
  std::vector<std::vector<int>> blocks;  ///< their bars

  std::vector<int> articulation_joints() const {
    std::vector<int> joints;
    for (std::size_t j = 0; j < joined_.size(); ++j)
      if (joined_[j]) joints.push_back(int(j));
    return joints;
  }

 private:
  struct Step {
    int joint, bar;  ///< bar: by which the joint was found; -1 at the root
    std::size_t next;
  };

  void discover(int joint, int bar) {
    found_[std::size_t(joint)] = low_[std::size_t(joint)] = clock_++;
    path_.push_back({joint, bar, 0});
  }

  void follow(int joint, int parent_bar, const Graph::Link& link) {
    const int other = found_[std::size_t(link.other)];
    if (link.bar == parent_bar) return;
    if (other < 0) {
      bars_.push_back(link.bar);
      discover(link.other, link.bar);
    } else if (other < found_[std::size_t(joint)]) {
      bars_.push_back(link.bar);
      low_[std::size_t(joint)] = std::min(low_[std::size_t(joint)], other);
    }
  }

  /// The bars met since `bar` are a block of their own.
  void cut(int bar) {
    std::size_t first = bars_.size() - 1;
    while (bars_[first] != bar) --first;
    if (first + 1 == bars_.size())
      bridges.push_back(bar);
    else
      blocks.emplace_back(bars_.begin() + std::ptrdiff_t(first), bars_.end());
    bars_.resize(first);
  }

  const Graph& graph_;
  std::vector<int> found_, low_;       ///< -1: not found (njoint)
  std::vector<unsigned char> joined_;  ///< articulation joints (njoint)
  std::vector<Step> path_;
  std::vector<int> bars_;
  int clock_ = 0;
};

/// Longest of the shortest paths, by two breadth-first searches.
class Diameter {
 public:
  explicit Diameter(const Graph& graph)
      : graph_(graph), distance_(std::size_t(graph.joint_count()), -1) {}

  int of(int start) { return farthest(farthest(start).first).second; }

 private:
  /// The joint found last, and its distance.
  std::pair<int, int> farthest(int start) {
    queue_.assign(1, start);
    distance_[std::size_t(start)] = 0;
    for (std::size_t head = 0; head < queue_.size(); ++head) {
      const int joint = queue_[head];
      for (const Graph::Link& link : graph_.links(joint)) {
        int& distance = distance_[std::size_t(link.other)];
        if (distance >= 0) continue;
        distance = distance_[std::size_t(joint)] + 1;
        queue_.push_back(link.other);
      }
    }
    const std::pair<int, int> last = {queue_.back(), distance_[std::size_t(queue_.back())]};
    for (const int joint : queue_) distance_[std::size_t(joint)] = -1;
    return last;
  }

  const Graph& graph_;
  std::vector<int> distance_;  ///< -1: not reached (njoint)
  std::vector<int> queue_;
};

Block block_of(const Graph& graph, std::vector<int> bars, const Components& components) {
  Block block;
  block.bars = std::move(bars);
  std::sort(block.bars.begin(), block.bars.end());
  for (const int bar : block.bars) {
    const auto [p, q] = graph.ends(bar);
    block.joints.insert(block.joints.end(), {p, q});
  }
  std::sort(block.joints.begin(), block.joints.end());
  block.joints.erase(std::unique(block.joints.begin(), block.joints.end()), block.joints.end());
  block.component = components.of_joint[std::size_t(block.joints.front())];
  return block;
}

bool share_a_joint(const Block& a, const Block& b) {
  return std::any_of(a.joints.begin(), a.joints.end(), [&](int joint) {
    return std::binary_search(b.joints.begin(), b.joints.end(), joint);
  });
}

/// A 2-cycle has one block with two cycles, or two with one each.
std::string type_of(const std::vector<const Block*>& blocks) {
  if (blocks.size() == 1) return "theta";
  return share_a_joint(*blocks[0], *blocks[1]) ? "shared-joint" : "path";
}

}  // namespace

Classification classify(const Graph& graph) {
  const Components components = components_of(graph);
  BlockSearch search(graph);
  for (const int lowest : components.lowest_joint) search.search(lowest);

  Classification result;
  result.cycle_rank = cycle_rank(graph, components);
  result.bridges = std::move(search.bridges);
  std::sort(result.bridges.begin(), result.bridges.end());
  result.articulation_joints = search.articulation_joints();
  for (std::vector<int>& bars : search.blocks)
    result.blocks.push_back(block_of(graph, std::move(bars), components));
  std::sort(result.blocks.begin(), result.blocks.end(),
            [](const Block& a, const Block& b) { return a.bars.front() < b.bars.front(); });

  Diameter diameter(graph);
  for (std::size_t c = 0; c < components.joint_count.size(); ++c) {
    const int joints = components.joint_count[c], bars = components.bar_count[c];
    const int rank = bars - joints + 1, lowest = components.lowest_joint[c];
    result.components.push_back(
        {class_name(rank), "", lowest, joints, bars, rank, diameter.of(lowest)});
  }

  // types of the 2-cycles
  std::vector<std::vector<const Block*>> blocks_of(result.components.size());
  for (const Block& block : result.blocks)
    if (result.components[std::size_t(block.component)].cycle_rank == 2)
      blocks_of[std::size_t(block.component)].push_back(&block);
  for (std::size_t c = 0; c < blocks_of.size(); ++c)
    if (!blocks_of[c].empty()) result.components[c].type = type_of(blocks_of[c]);

  const ComponentClass* largest = nullptr;
  for (const ComponentClass& component : result.components)
    if (!largest || component.joints > largest->joints) largest = &component;
  if (largest) {
    result.class_name = largest->class_name;
    result.type = largest->type;
    result.diameter = largest->diameter;
  }
  return result;
}

}  // namespace ragdoll
