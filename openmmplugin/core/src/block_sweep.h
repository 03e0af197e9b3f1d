// Block sweep: outward from one joint over the block tree, each bridge and cycle block once, by the
// joint nearest to the start. Private to the block solver.

#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "block_newton.h"       // BlockNewton
#include "block_tree.h"         // BlockTree
#include "max_tree.h"           // MaxTree
#include "ragdoll/framework.h"  // Framework

namespace ragdoll {

class BlockSweep {
 public:
  BlockSweep(const Framework& framework, double tolerance);

  /// What a sweep visits: all of the component, or only what has a joint that the sweep moved. The
  /// result is the same where nothing else is broken.
  enum class Scope { all, moved };

  struct Tally {
    std::int64_t corrections = 0;  ///< bridges and blocks that were broken
    std::int64_t visits = 0;       ///< of bars
    std::int64_t held = 0;         ///< bridges and blocks that could not be met
    bool finite = true;
  };

  /// @param resolved  positions at which every bar was within tolerance, or empty: a block that
  ///                  cannot be met otherwise takes its shape from there
  Tally sweep(std::span<Vec3> x, std::span<const Vec3> resolved, int root, Scope scope);

  /// The joints that the last sweep moved.
  std::span<const int> moved() const { return moved_; }

  /// Largest relative violation of the bars, each where it was visited last.
  double residual() const { return residual_.largest(); }

  const BlockTree& tree() const { return tree_; }

 private:
  struct Front {
    int joint;
    int from;  ///< the block by which it was reached, ~bar of a bridge, or `nowhere`
  };

  bool cross_bridge(int bar, int near, int far);
  void enter_block(int index, int entry);
  bool resolve_block(const CycleBlock& block, BlockNewton& newton, int entry);
  void hang_from_entry(const CycleBlock& block, int entry);
  void share_evenly(const CycleBlock& block);
  void place_entry(BlockNewton& newton, int entry);
  void shake(double size, int attempt);
  void move(int joint) { moved_.push_back(joint); }

  const Framework& framework_;
  double tolerance_;
  BlockTree tree_;
  std::vector<std::unique_ptr<BlockNewton>> newtons_;  ///< made when needed (nblock)
  std::vector<std::int64_t> entered_;                  ///< in which sweep, last (nblock)
  std::int64_t sweeps_ = 0;
  MaxTree residual_;

  // the sweep at hand
  std::span<Vec3> x_;
  std::span<const Vec3> resolved_;
  Scope scope_ = Scope::all;
  Tally tally_;
  std::vector<Front> front_;
  std::vector<int> moved_;

  // the block at hand
  std::vector<Vec3> start_, y_;
  std::vector<std::uint8_t> pinned_, seen_;
  std::vector<int> queue_;
};

}  // namespace ragdoll
