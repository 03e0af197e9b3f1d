#include "block_tree.h"

#include <algorithm>  // lower_bound, sort, min
#include <tuple>      // tie
#include <utility>    // pair, exchange

#include "ragdoll/classify.h"  // classify

namespace ragdoll {
namespace {

/// The graph, and a bar from each fixed joint to the next one of its component.
Graph grounded_graph(const Framework& framework, std::vector<int>& ground) {
  const int joints = framework.joint_count();
  std::vector<std::pair<int, int>> ends;
  ends.reserve(framework.bars().size());
  for (const Bar& bar : framework.bars()) ends.emplace_back(bar.p, bar.q);
  ground.assign(std::size_t(framework.components().count()), -1);
  std::vector<int> last = ground;
  for (int j = 0; j < joints; ++j) {
    if (!framework.fixed()[std::size_t(j)]) continue;
    const auto component = std::size_t(framework.components().of_joint[std::size_t(j)]);
    if (last[component] >= 0)
      ends.emplace_back(last[component], j);
    else
      ground[component] = j;
    last[component] = j;
  }
  return Graph(joints, ends);
}

void link(CycleBlock& block) {
  const std::size_t joints = block.joints.size();
  block.link_begin.assign(joints + 1, 0);
  for (const auto& bar : block.local_bars) {
    ++block.link_begin[std::size_t(bar.p) + 1];
    ++block.link_begin[std::size_t(bar.q) + 1];
  }
  for (std::size_t j = 0; j < joints; ++j) block.link_begin[j + 1] += block.link_begin[j];
  block.links.resize(2 * block.local_bars.size());
  std::vector<int> next = block.link_begin;
  for (int k = 0; k < int(block.local_bars.size()); ++k) {
    const auto& bar = block.local_bars[std::size_t(k)];
    block.links[std::size_t(next[std::size_t(bar.p)]++)] = {k, bar.q};
    block.links[std::size_t(next[std::size_t(bar.q)]++)] = {k, bar.p};
  }
}

/// Bars breadth-first, so that those that share a joint have numbers close to each other.
void renumber(CycleBlock& block) {
  std::vector<int> order, queue = {0};
  std::vector<char> seen(block.joints.size(), 0), listed(block.bars.size(), 0);
  seen[0] = 1;
  for (std::size_t head = 0; head < queue.size(); ++head) {
    const auto j = std::size_t(queue[head]);
    for (int k = block.link_begin[j]; k < block.link_begin[j + 1]; ++k) {
      const CycleBlock::Link link = block.links[std::size_t(k)];
      if (!std::exchange(listed[std::size_t(link.bar)], 1)) order.push_back(link.bar);
      if (!std::exchange(seen[std::size_t(link.other)], 1)) queue.push_back(link.other);
    }
  }
  // bars that only the ground joins to the others
  for (int k = 0; k < int(listed.size()); ++k)
    if (!listed[std::size_t(k)]) order.push_back(k);
  const std::vector<int> bars = block.bars;
  const std::vector<CycleBlock::LocalBar> local_bars = block.local_bars;
  for (std::size_t k = 0; k < order.size(); ++k) {
    block.bars[k] = bars[std::size_t(order[k])];
    block.local_bars[k] = local_bars[std::size_t(order[k])];
  }
}

void couple(CycleBlock& block) {
  const auto side = [&](int bar, int joint) {
    return block.local_bars[std::size_t(bar)].q == joint ? 1.0 : -1.0;
  };
  for (int j = 0; j < int(block.joints.size()); ++j)
    for (int a = block.link_begin[std::size_t(j)]; a < block.link_begin[std::size_t(j) + 1]; ++a)
      for (int b = block.link_begin[std::size_t(j)]; b < a; ++b) {
        // links of a joint are in ascending order of their bars
        const int row = block.links[std::size_t(a)].bar, column = block.links[std::size_t(b)].bar;
        block.couplings.push_back({row, column, j, side(row, j) * side(column, j)});
      }
  std::sort(block.couplings.begin(), block.couplings.end(), [](const auto& x, const auto& y) {
    return std::tie(x.column, x.row) < std::tie(y.column, y.row);
  });
  for (int k = 0; k < int(block.bars.size()); ++k) block.first_coupled.push_back(k);
  for (const auto& c : block.couplings) {
    int& first = block.first_coupled[std::size_t(c.row)];
    first = std::min(first, c.column);
  }
}

}  // namespace

int CycleBlock::local(int joint) const {
  return int(std::lower_bound(joints.begin(), joints.end(), joint) - joints.begin());
}

BlockTree::BlockTree(const Framework& framework) {
  const Graph graph = grounded_graph(framework, ground);
  const int bar_count = int(framework.bars().size());
  block_of_bar.assign(std::size_t(bar_count), -1);
  Classification classification = classify(graph);
  blocks.reserve(classification.blocks.size());
  for (Block& found : classification.blocks) {
    CycleBlock block;
    block.joints = std::move(found.joints);
    for (const int bar : found.bars)
      if (bar < bar_count) block.bars.push_back(bar);
    for (const int k : block.bars) {
      const Bar& bar = framework.bars()[std::size_t(k)];
      block.local_bars.push_back({block.local(bar.p), block.local(bar.q), bar.length});
      block.mean_length += bar.length / double(block.bars.size());
      block_of_bar[std::size_t(k)] = int(blocks.size());
    }
    link(block);
    renumber(block);
    link(block);
    couple(block);
    blocks.push_back(std::move(block));
  }
}

}  // namespace ragdoll
