// Block sweep: outward from one joint over the block tree, each bridge and cycle block once, by the
// joint nearest to the start. Private to the block solver.

#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "block_entry.h"        // BlockEntry
#include "block_tree.h"         // BlockTree
#include "max_tree.h"           // MaxTree
#include "ragdoll/framework.h"  // Framework
#include "ragdoll/tolerance.h"  // Tolerance

namespace ragdoll {

class BlockSweep {
 public:
  BlockSweep(const Framework& framework, const Tolerance& tolerance);

  /// What a sweep visits: all of the component, or only what has a joint that the sweep moved. The
  /// result is the same where nothing else is broken.
  enum class Scope { all, moved };

  struct Tally {
    std::int64_t corrections = 0;  ///< bridges and blocks that were broken
    std::int64_t visits = 0;       ///< of bars
    std::int64_t held = 0;         ///< bridges and blocks that could not be met
    std::int64_t carried = 0;      ///< blocks that kept an earlier shape
    bool finite = true;
  };

  Tally sweep(std::span<Vec3> x, int root, Scope scope);

  struct Moved {
    int joint;
    Vec3 was;
  };
  /// The joints that the last sweep moved, once each.
  std::span<const Moved> moved() const { return moved_; }

  /// Largest violation of the bars, each where it was visited last.
  BarViolation residual() {
    residual_.settle();
    return residual_.largest();
  }

  const BlockTree& tree() const { return tree_; }

 private:
  struct Front {
    int joint;
    int from;   ///< the block by which it was reached, ~bar of a bridge, or `nowhere`
    int moved;  ///< in this sweep: index in moved_; -1: not
  };

  void fetch_around(int joint) const;
  int last_moved(bool moves) const { return moves ? int(moved_.size()) - 1 : -1; }
  void reach(int joint, int from, int moved) {
    if (reached_ == front_.size()) front_.resize(2 * reached_);
    front_[reached_++] = {joint, from, moved};
  }
  template <Scope scope>
  void go_outward();
  void enter_block(int index, int entry, const Front& at);
  bool turn_block(int index, int entry, Vec3 was);

  const Framework& framework_;
  Tolerance tolerance_;
  BlockTree tree_;
  BlockEntry entry_;
  std::vector<std::int64_t> entered_;  ///< in which sweep, last (nblock)
  std::int64_t sweeps_ = 0;
  std::vector<double>
      turned_;  ///< what rounding may have added since it was looked at, nm (nblock)
  MaxTree residual_;

  // the sweep at hand
  std::span<Vec3> x_;
  Scope scope_ = Scope::all;
  Tally tally_;
  std::vector<Front> front_;  ///< with room for more
  std::size_t reached_ = 0;   ///< joints in it
  std::vector<Moved> moved_;
};

}  // namespace ragdoll
