#include "block_tree.h"

#include <algorithm>  // lower_bound, sort, min, max, any_of
#include <tuple>      // tie
#include <utility>    // pair, exchange, move

namespace ragdoll {
namespace {

/// The graph, and a bar from each fixed joint to the next one of its component.
Graph grounded_graph(const Framework& framework, std::vector<int>& ground) {
  std::vector<std::pair<int, int>> ends;
  ends.reserve(framework.bars().size());
  for (const Bar& bar : framework.bars()) ends.emplace_back(bar.p, bar.q);
  std::vector<int> last = ground;
  for (int j = 0; j < framework.joint_count(); ++j) {
    if (!framework.fixed()[std::size_t(j)]) continue;
    const auto component = std::size_t(framework.components().of_joint[std::size_t(j)]);
    if (last[component] >= 0)
      ends.emplace_back(last[component], j);
    else
      ground[component] = j;
    last[component] = j;
  }
  return Graph(framework.joint_count(), ends);
}

/// One block while it is made.
struct Draft {
  using LocalBar = CycleBlock::LocalBar;
  using Link = CycleBlock::Link;
  using Coupling = CycleBlock::Coupling;

  std::vector<int> joints, ring, bars, link_begin;
  std::vector<LocalBar> local_bars;
  std::vector<Link> links;
  std::vector<Coupling> couplings;
  bool grounded = false;

  void link() {
    link_begin.assign(joints.size() + 1, 0);
    for (const auto& bar : local_bars) {
      ++link_begin[std::size_t(bar.p) + 1];
      ++link_begin[std::size_t(bar.q) + 1];
    }
    for (std::size_t j = 0; j < joints.size(); ++j) link_begin[j + 1] += link_begin[j];
    links.resize(2 * local_bars.size());
    std::vector<int> next = link_begin;
    for (int k = 0; k < int(local_bars.size()); ++k) {
      const auto& bar = local_bars[std::size_t(k)];
      links[std::size_t(next[std::size_t(bar.p)]++)] = {k, bar.q};
      links[std::size_t(next[std::size_t(bar.q)]++)] = {k, bar.p};
    }
  }

  bool is_ring() const {
    for (std::size_t j = 0; j < joints.size(); ++j)
      if (link_begin[j + 1] - link_begin[j] != 2) return false;
    // fixed joints may hold several pieces together
    return joints.size() == bars.size() && !grounded;
  }

  /// Bars breadth-first, so that those that share a joint have numbers close to each other.
  void renumber() {
    std::vector<int> order, queue = {0};
    std::vector<char> seen(joints.size(), 0), listed(bars.size(), 0);
    seen[0] = 1;
    for (std::size_t head = 0; head < queue.size(); ++head) {
      const auto j = std::size_t(queue[head]);
      for (int k = link_begin[j]; k < link_begin[j + 1]; ++k) {
        const Link at = links[std::size_t(k)];
        if (!std::exchange(listed[std::size_t(at.bar)], 1)) order.push_back(at.bar);
        if (!std::exchange(seen[std::size_t(at.other)], 1)) queue.push_back(at.other);
      }
    }
    // bars that only the ground joins to the others
    for (int k = 0; k < int(listed.size()); ++k)
      if (!listed[std::size_t(k)]) order.push_back(k);
    take(order);
  }

  /// Bars around the ring that the block is, if every joint has two.
  void go_around() {
    ring.assign(1, 0);
    std::vector<int> order;
    for (int bar = -1; order.size() < bars.size();) {
      const auto at = std::size_t(link_begin[std::size_t(ring.back())]);
      const Link& next = links[at].bar != bar ? links[at] : links[at + 1];
      bar = next.bar;
      order.push_back(bar);
      ring.push_back(next.other);
    }
    ring.pop_back();
    take(order);
  }

  void take(const std::vector<int>& order) {
    const std::vector<int> old_bars = bars;
    const std::vector<LocalBar> old_local_bars = local_bars;
    for (std::size_t k = 0; k < order.size(); ++k) {
      bars[k] = old_bars[std::size_t(order[k])];
      local_bars[k] = old_local_bars[std::size_t(order[k])];
    }
  }

  void couple() {
    const auto side = [&](int bar, int joint) {
      return local_bars[std::size_t(bar)].q == joint ? 1 : -1;
    };
    couplings.clear();
    for (int j = 0; j < int(joints.size()); ++j)
      for (int a = link_begin[std::size_t(j)]; a < link_begin[std::size_t(j) + 1]; ++a)
        for (int b = link_begin[std::size_t(j)]; b < a; ++b) {
          // links of a joint are in ascending order of their bars
          const int row = links[std::size_t(a)].bar, column = links[std::size_t(b)].bar;
          couplings.push_back({row, column, j, side(row, j) * side(column, j)});
        }
    std::sort(couplings.begin(), couplings.end(), [](const auto& x, const auto& y) {
      return std::tie(x.column, x.row) < std::tie(y.column, y.row);
    });
  }
};

template <class T>
std::span<const T> part(const std::vector<T>& all, std::size_t begin, std::size_t count) {
  return {all.data() + begin, count};
}

}  // namespace

BlockTree::BlockTree(const Framework& framework, const Tolerance& tolerance)
    : ground_(std::size_t(framework.components().count()), -1) {
  const bool any_fixed = std::any_of(framework.fixed().begin(), framework.fixed().end(),
                                     [](std::uint8_t fixed) { return fixed != 0; });
  const Classification classification =
      classify(any_fixed ? grounded_graph(framework, ground_) : framework.graph());
  for (const Block& found : classification.blocks) add(found, framework, tolerance);
  make_ways(framework);
}

void BlockTree::add(const Block& found, const Framework& framework, const Tolerance& tolerance) {
  Draft draft;
  draft.joints = found.joints;
  const auto local = [&](int joint) {
    return int(std::lower_bound(draft.joints.begin(), draft.joints.end(), joint) -
               draft.joints.begin());
  };
  double length = 0;
  for (const int k : found.bars) {
    if (k >= int(framework.bars().size())) {
      draft.grounded = true;
      continue;
    }
    const Bar& bar = framework.bars()[std::size_t(k)];
    draft.bars.push_back(k);
    // a hair less, so that what rounds to the slack is inside it
    draft.local_bars.push_back(
        {local(bar.p), local(bar.q), bar.length, (1 + 1e-15) / tolerance.slack(bar.length)});
    length += bar.length;
  }
  draft.link();
  if (draft.is_ring())
    draft.go_around();
  else
    draft.renumber();
  draft.link();
  draft.couple();

  const auto append = [](auto& to, const auto& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  append(joints_, draft.joints);
  if (draft.ring.empty()) draft.ring.assign(draft.joints.size(), -1);
  append(rings_, draft.ring);
  append(bars_, draft.bars);
  append(local_bars_, draft.local_bars);
  append(link_begin_, draft.link_begin);
  append(links_, draft.links);
  append(couplings_, draft.couplings);
  has_fixed_joints_.push_back(std::any_of(found.joints.begin(), found.joints.end(), [&](int joint) {
    return framework.fixed()[std::size_t(joint)] != 0;
  }));
  joint_begin_.push_back(joints_.size());
  bar_begin_.push_back(bars_.size());
  coupling_begin_.push_back(couplings_.size());
  mean_length_.push_back(length / double(std::max<std::size_t>(draft.bars.size(), 1)));
  most_joints = std::max(most_joints, draft.joints.size());
  most_bars = std::max(most_bars, draft.bars.size());
}

CycleBlock BlockTree::block(int index) const {
  const auto b = std::size_t(index);
  const std::size_t joint = joint_begin_[b], joints = joint_begin_[b + 1] - joint;
  const std::size_t bar = bar_begin_[b], bars = bar_begin_[b + 1] - bar;
  CycleBlock block;
  block.joints = part(joints_, joint, joints);
  if (rings_[joint] >= 0) block.ring = part(rings_, joint, joints);
  block.bars = part(bars_, bar, bars);
  block.local_bars = part(local_bars_, bar, bars);
  // one entry more than joints in each block
  block.link_begin = part(link_begin_, joint + b, joints + 1);
  block.links = part(links_, 2 * bar, 2 * bars);
  block.couplings =
      part(couplings_, coupling_begin_[b], coupling_begin_[b + 1] - coupling_begin_[b]);
  block.mean_length = mean_length_[b];
  return block;
}

void BlockTree::make_ways(const Framework& framework) {
  std::vector<int> block_of_bar(framework.bars().size(), -1);
  for (int b = 0; b < block_count(); ++b)
    for (std::size_t k = bar_begin_[std::size_t(b)]; k < bar_begin_[std::size_t(b) + 1]; ++k)
      block_of_bar[std::size_t(bars_[k])] = b;
  way_begin_.reserve(std::size_t(framework.joint_count()) + 1);
  way_begin_.push_back(0);
  ways_.reserve(2 * framework.bars().size());
  std::vector<int> entered_by(std::size_t(block_count()), -1);
  for (int joint = 0; joint < framework.joint_count(); ++joint) {
    for (const Graph::Link& link : framework.graph().links(joint)) {
      const int index = block_of_bar[std::size_t(link.bar)];
      if (index < 0) {
        ways_.push_back({link.other, link.bar, framework.bars()[std::size_t(link.bar)].length});
        continue;
      }
      if (std::exchange(entered_by[std::size_t(index)], joint) == joint) continue;
      const std::span<const int> joints = block(index).joints;
      const auto own = std::lower_bound(joints.begin(), joints.end(), joint) - joints.begin();
      ways_.push_back({int(own), ~index, 0});
    }
    way_begin_.push_back(int(ways_.size()));
  }
}

}  // namespace ragdoll
