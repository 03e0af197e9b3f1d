// Block tree: a framework's bridges and cycle blocks, made once. It has no root: a sweep that goes
// outward from any joint meets every block once, by one joint. Private to the block solver.

#pragma once
#include <algorithm>  // min, max
#include <cstdint>
#include <span>
#include <vector>

#include "ragdoll/classify.h"   // Block
#include "ragdoll/framework.h"  // Framework
#include "ragdoll/tolerance.h"  // Tolerance

namespace ragdoll {

/// A cycle block with joints and bars numbered from 0: a view into the tree's arrays.
struct CycleBlock {
  struct LocalBar {
    int p, q;
    double length;
    double per_slack;  ///< 1 / what the tolerance allows
  };
  struct Link {
    int bar, other;
  };
  /// Two bars that share a joint: an entry below the diagonal of J J^T.
  struct Coupling {
    int row, column;
    int joint;
    int sign;  ///< of the product of the bars' unit vectors from p to q
  };

  std::span<const int> joints;           ///< of the framework, ascending (njoint)
  std::span<const int> bars;             ///< of the framework, breadth-first (nbar)
  std::span<const LocalBar> local_bars;  ///< (nbar)
  std::span<const int> link_begin;       ///< into links (njoint + 1)
  std::span<const Link> links;           ///< (2 nbar)
  std::span<const Coupling> couplings;   ///< by column, then row
  std::span<const int> ring;             ///< joints around it, if it is one cycle: the k-th bar
                                         ///< joins the k-th and the next (njoint); else empty
  double mean_length = 0;

  std::span<const Link> links_of(std::size_t joint) const {
    return links.subspan(std::size_t(link_begin[joint]),
                         std::size_t(link_begin[joint + 1] - link_begin[joint]));
  }
};

/// All fixed joints of a component count as held by one rigid piece, the ground, so that what lies
/// between two of them is a cycle block too.
class BlockTree {
 public:
  BlockTree(const Framework& framework, const Tolerance& tolerance);

  /// The way from a joint over a bridge, or into a block.
  struct Way {
    int to;         ///< the joint beyond the bridge, or the joint's own number in the block
    int bar;        ///< or ~index of the block
    double length;  ///< of the bridge
  };

  /// In the order in which the joint meets its bars; a block once.
  std::span<const Way> ways(int joint) const {
    return {ways_.data() + way_begin_[std::size_t(joint)],
            ways_.data() + way_begin_[std::size_t(joint) + 1]};
  }

  /// Asks the memory for the ways of joints between two, by way of one that is needed at once.
  void fetch(int from, int joint, int to) const {
    for (int j = from; j <= to; j += 16) __builtin_prefetch(&way_begin_[std::size_t(j)]);
    // about two ways to a joint
    const int at = way_begin_[std::size_t(joint)], last = int(ways_.size()) - 1;
    for (int w = std::max(at - 2 * (joint - from), 0); w <= std::min(at + 2 * (to - joint), last);
         w += 4)
      __builtin_prefetch(&ways_[std::size_t(w)]);
  }

  int block_count() const { return int(mean_length_.size()); }
  std::span<const int> joints_of(int block) const { return part_of(joints_, joint_begin_, block); }
  std::span<const int> bars_of(int block) const { return part_of(bars_, bar_begin_, block); }
  std::span<const CycleBlock::LocalBar> local_bars_of(int block) const {
    return part_of(local_bars_, bar_begin_, block);
  }
  std::span<const CycleBlock::Link> links_of(int block, int joint) const {
    const auto b = std::size_t(block);
    const int* const begin = &link_begin_[joint_begin_[b] + b + std::size_t(joint)];
    return {links_.data() + 2 * bar_begin_[b] + begin[0], std::size_t(begin[1] - begin[0])};
  }
  bool has_fixed_joints(int block) const { return has_fixed_joints_[std::size_t(block)] != 0; }
  CycleBlock block(int index) const;

  std::size_t most_joints = 0, most_bars = 0;  ///< of a block

  /// A fixed joint of a component, or -1.
  int ground(int component) const { return ground_[std::size_t(component)]; }

 private:
  void add(const Block& block, const Framework& framework, const Tolerance& tolerance);
  void make_ways(const Framework& framework);

  template <class T>
  static std::span<const T> part_of(const std::vector<T>& all,
                                    const std::vector<std::size_t>& begin, int block) {
    const auto b = std::size_t(block);
    return {all.data() + begin[b], begin[b + 1] - begin[b]};
  }

  std::vector<int> ground_;  ///< (ncomponent)
  std::vector<int> way_begin_;
  std::vector<Way> ways_;

  // the blocks, one behind the other
  std::vector<std::size_t> joint_begin_ = {0}, bar_begin_ = {0}, coupling_begin_ = {0};
  std::vector<double> mean_length_;
  std::vector<std::uint8_t> has_fixed_joints_;
  std::vector<int> joints_, rings_, bars_, link_begin_;
  std::vector<CycleBlock::LocalBar> local_bars_;
  std::vector<CycleBlock::Link> links_;
  std::vector<CycleBlock::Coupling> couplings_;
};

}  // namespace ragdoll
