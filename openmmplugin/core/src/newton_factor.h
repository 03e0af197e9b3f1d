// BlockFactor: a sparse symmetric matrix of 3x3 blocks, one row of blocks for each joint, and its
// LDL^T. Private to the solver `newton`.

#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>  // pair
#include <vector>

#include "ragdoll/vec3.h"  // Vec3

namespace ragdoll {

/// A 3x3 block, column by column.
using Block3 = std::array<double, 9>;

/// The pattern is made of pairs that stay and of pairs that come and go. The order of elimination
/// is AMD's for the pairs that stay; it and their places are found once. The others only cost the
/// elimination tree anew: integers, O(entries of the factor).
class BlockFactor {
 public:
  /// @param pairs  of joints, in any order, with repeats
  BlockFactor(int joint_count, const std::vector<std::pair<int, int>>& pairs);

  /// Pairs that come and go, replacing the former ones; no pair twice, but it may be one that
  /// stays.
  void set_extra_pairs(std::span<const std::pair<int, int>> pairs);

  /// All blocks 0.
  void clear();

  /// @param place  from place_of(p, q). Adds factor * a b^T at (p, q), and so at (q, p) its
  ///               transpose
  void add(int place, int p, int q, const Vec3& a, const Vec3& b, double factor);
  void add_extra(std::size_t pair, const Vec3& a, const Vec3& b, double factor);
  /// Subtracts the stiffness u u^T + turn (1 - u u^T) at a pair, or adds it at a joint (u need not
  /// be a unit there if turn is 0).
  void add_spring(int place, const Vec3& u, double turn);
  void add_diagonal(int joint, const Vec3& u, double turn);

  /// Where the block of a pair that stays is kept.
  int place_of(int p, int q) const;

  /// Factors the matrix plus `shift` times the identity. @return false if it is not positive
  bool factor(double shift);

  /// Solves in place, joint by joint.
  void solve(std::span<Vec3> x) const;

  /// Blocks below the diagonal of the factor.
  std::size_t factor_blocks() const { return lower_.size(); }

 private:
  void order(int joint_count, const std::vector<std::pair<int, int>>& pairs);
  void analyse();
  template <class Visit>
  void each_row_of(int column, Visit visit) const;
  bool factor_column(int k, double shift);

  int n_ = 0;
  std::vector<int> rank_;   ///< of each joint in the elimination (njoint)
  std::vector<int> joint_;  ///< of each rank (njoint)

  // the matrix above its diagonal, by columns of ranks
  std::vector<int> column_begin_, row_;
  std::vector<Block3> block_, diagonal_;
  std::vector<int> extra_begin_, extra_row_;
  std::vector<int> extra_place_;  ///< of each extra pair
  std::vector<std::uint8_t> extra_turned_;
  std::vector<Block3> extra_block_;

  // the factor below its diagonal, by columns
  std::vector<int> parent_;
  std::vector<std::size_t> lower_begin_, lower_end_;
  std::vector<int> lower_row_;
  std::vector<Block3> lower_, inverse_;  ///< inverse_ of D's blocks
  std::vector<Block3> work_;             ///< zero between columns
  std::vector<int> pattern_, stack_, mark_;
};

}  // namespace ragdoll
