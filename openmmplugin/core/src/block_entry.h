// Block entry: one cycle block, entered by a joint that may have moved, is brought back within
// tolerance. Private to the block solver.

#pragma once
#include <cmath>  // abs
#include <cstdint>
#include <span>
#include <vector>

#include "block_newton.h"       // BlockNewton
#include "block_ring.h"         // BlockRing
#include "block_tree.h"         // BlockTree, CycleBlock
#include "max_tree.h"           // BarViolation
#include "ragdoll/framework.h"  // Framework

namespace ragdoll {

/// What became of a block.
enum class BlockOutcome {
  whole,    ///< it was within tolerance, and no joint moved
  met,      ///< it was resolved
  carried,  ///< no deformation resolved it: it keeps its shape, carried with its entry joint
  held,     ///< it is where it is nearest
  not_finite,
};

/// A rotation about a joint that moved from `was` to `at`, after which a point lies in the
/// direction in which it lay before, seen from there.
class Turn {
 public:
  Turn(const Vec3& was, const Vec3& at, const Vec3& point);

  /// Of what lay at `place` when the joint was at `was`.
  Vec3 operator()(const Vec3& place) const {
    const Vec3 arm = place - was_;
    // two half turns, about the first direction and about the bisector of the two
    const Vec3 half = 2 * from_.dot(arm) * from_ - arm;
    return at_ + (2 * axis_.dot(half) * axis_ - half);
  }

  static constexpr std::size_t most_joints = 10;  ///< in a block that turns as it is
  /// Share of the tolerance that a block which turns is within, so that there is room for what
  /// rounding adds; and that, in shares of the coordinates' size.
  static constexpr double whole = 0.75, rounding = 4e-15;

 private:
  Vec3 was_, at_, from_, axis_;
};

/// The entry joint stays, and so do fixed joints. In turn, until the bars are met:
/// - a small block whose entry joint alone moved turns about it like a rigid body;
/// - a 1/0 pre-pass outward from the entry joint, then Newton. Each bar is looked at once before
///   the first step. Blocks with many bars for their joints start as they are instead;
/// - Newton as they are, and after plain .5/.5 sweeps;
/// - its shape before its entry joint moved, carried along whole;
/// - Newton from shaken joints, by random numbers that are the same each time.
class BlockEntry {
 public:
  BlockEntry(const Framework& framework, const BlockTree& tree);

  /// @param entry  number in the block
  /// @param x      positions of the framework's joints
  /// @param was    where the entry joint was before the sweep moved it, or null
  BlockOutcome enter(int index, int entry, std::span<const Vec3> x, const Vec3* was);

  // of the block entered last
  const CycleBlock& block() const { return newton_.block(); }
  std::span<const Vec3> before() const { return start_; }
  std::span<const Vec3> after() const { return y_; }
  BarViolation violation(std::size_t bar) const {
    const double error = std::abs(by_ring_ ? ring_.error(bar) : newton_.error(bar));
    return {error / block().local_bars[bar].length, error};
  }

  std::int64_t visits() const { return newton_.visits + ring_.visits; }  ///< of bars, in total

 private:
  bool turn(const Vec3& was);
  double hang();
  void share_evenly();
  bool find_entry(Vec3& place);
  void shake(double size, int attempt);
  bool newton(double first_mu);
  bool deform(double most);
  bool carry(const Vec3* was);

  const Framework& framework_;
  BlockNewton newton_;
  BlockRing ring_;

  // the block at hand
  int entry_ = 0;
  bool others_pinned_ = false;
  bool by_ring_ = false;  ///< ring_ did it
  std::vector<Vec3> start_, y_, nearest_;
  double nearest_error_ = 0;
  std::vector<std::uint8_t> pinned_, seen_, in_tree_;
  std::vector<int> queue_;
};

}  // namespace ragdoll
