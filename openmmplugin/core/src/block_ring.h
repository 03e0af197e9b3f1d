// Block ring: resolves a cycle block that is one ring, by arithmetic that the ring makes short.
// Private to the block solver.

#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "block_tree.h"    // CycleBlock
#include "ragdoll/vec3.h"  // Vec3

namespace ragdoll {

/// What BlockEntry does first, for rings whose entry joint alone is pinned: the 1/0 pre-pass along
/// both arms to where they meet, then Newton. With the entry joint as its ends a ring is a chain,
/// and J J^T has one entry beside the diagonal: it is eliminated from both ends at once.
class BlockRing {
 public:
  explicit BlockRing(std::size_t most_bars);

  /// @param y  positions, changed only where it returns true (njoint)
  /// @return true if all bars are within tolerance; false: try something else
  bool resolve(const CycleBlock& block, int entry, std::span<Vec3> y);

  bool moved() const { return moved_; }  ///< whether it had to

  /// Of a bar of the block as resolve() left it, nm.
  double error(std::size_t bar) const {
    return chain_[bar >= first_ ? bar - first_ : bar + bars_ - first_].error;
  }

  std::int64_t visits = 0;  ///< bars looked at, in total

 private:
  /// A bar from the k-th joint of the chain to the next.
  struct Link {
    Vec3 unit;
    double error;
    double length, per_slack;
  };

  void load(const CycleBlock& block, int entry, std::span<const Vec3> y);
  void see(Link& link, const Vec3& from, const Vec3& to) const;
  bool hang(std::size_t bar, std::size_t near, std::size_t far);
  void hang_arms();
  bool newton();
  bool solve(double mu);

  std::size_t bars_ = 0, first_ = 0;  ///< first_: the block's bar that the chain begins with
  bool moved_ = false;
  std::vector<Vec3> x_, trial_;            ///< the entry joint first and last (nbar + 1)
  std::vector<Link> chain_, trial_chain_;  ///< (nbar)
  std::vector<double> pivot_, coupling_, multiplier_;  ///< (nbar); pivots inverted
};

}  // namespace ragdoll
