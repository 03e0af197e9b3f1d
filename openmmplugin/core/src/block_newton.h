// Block Newton: resolves one cycle block with some of its joints pinned. Private to the block
// solver.

#pragma once
#include <Eigen/SparseCholesky>  // SimplicialLDLT
#include <cmath>                 // abs, sqrt
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "block_elimination.h"  // BlockElimination
#include "block_tree.h"         // BlockTree, CycleBlock
#include "ragdoll/vec3.h"       // Vec3

namespace ragdoll {

/// Least-norm Newton steps, damped as Levenberg and Marquardt do: dx = -J^T (J J^T + mu)^-1 c, with
/// c = |q - p| - length. Small blocks by BlockElimination, large ones by Eigen's sparse LDL^T.
class BlockNewton {
 public:
  explicit BlockNewton(const BlockTree& tree);

  /// The block that all of the following is about.
  void enter(int index);
  const CycleBlock& block() const { return block_; }
  bool has_fixed_joints() const { return tree_.has_fixed_joints(index_); }

  /// Looks at all bars. @return the largest violation, as a share of what the tolerance allows
  double look(std::span<const Vec3> x);

  /// Looks at one bar, whose ends are at p and q. @return its violation, as look() does
  double look_at(std::size_t bar, const Vec3& p, const Vec3& q) {
    ++visits;
    return see(looks_[bar], block_.local_bars[bar], p, q);
  }

  /// From the p of the bar seen last to its q.
  const Vec3& unit(std::size_t bar) const { return looks_[bar].unit; }

  double error(std::size_t bar) const { return looks_[bar].error; }  ///< nm, seen last
  /// The same, as a share of what the tolerance allows.
  double share(std::size_t bar) const {
    return std::abs(looks_[bar].error) * block_.local_bars[bar].per_slack;
  }

  /// The bar is at its length now, and points where it did.
  void straighten(std::size_t bar) { looks_[bar].error = 0; }

  /// Moves the joints until all bars are within half the tolerance, so that rounding elsewhere does
  /// not break them again. What cannot be met is left where it is nearest. Starts from the looks,
  /// which must be those at x.
  /// @param pinned  1: does not move (njoint of the block)
  /// @return true if all bars are within the tolerance
  bool resolve(std::span<Vec3> x, std::span<const std::uint8_t> pinned, double first_mu);

  std::int64_t visits = 0;  ///< bars looked at, in total

 private:
  using Sparse = Eigen::SparseMatrix<double>;
  struct SparseSystem {
    Sparse matrix;               ///< lower triangle of J J^T + mu
    std::vector<int> diagonal;   ///< where its entries are in the matrix' values (nbar)
    std::vector<int> couplings;  ///< the same of the couplings
    Eigen::SimplicialLDLT<Sparse> solver;
    Eigen::VectorXd right, solution;
  };
  struct Look {
    Vec3 unit;
    double error;  ///< nm
  };

  static double see(Look& look, const CycleBlock::LocalBar& bar, const Vec3& p, const Vec3& q) {
    const double x = q[0] - p[0], y = q[1] - p[1], z = q[2] - p[2];
    const double distance = std::sqrt(x * x + y * y + z * z);
    if (distance > 0) {
      const double inverse = 1 / distance;
      look.unit = {x * inverse, y * inverse, z * inverse};
    } else {
      look.unit = {1, 0, 0};
    }
    look.error = distance - bar.length;
    return std::abs(look.error) * bar.per_slack;
  }
  double look(std::span<const Vec3> x, std::vector<Look>& looks);
  double merit_of(const std::vector<Look>& looks) const;
  double largest() const;
  void analyse(SparseSystem& system) const;
  bool solve(std::span<const std::uint8_t> pinned, double mu);
  bool eliminate(BlockElimination& elimination, std::span<const std::uint8_t> pinned, double mu);
  bool solve_sparse(SparseSystem& system, std::span<const std::uint8_t> pinned, double mu);

  double diagonal(std::size_t bar, std::span<const std::uint8_t> pinned) const {
    const auto& b = block_.local_bars[bar];
    return double(2 - pinned[std::size_t(b.p)] - pinned[std::size_t(b.q)]);
  }
  double coupling(const CycleBlock::Coupling& c, std::span<const std::uint8_t> pinned) const {
    if (pinned[std::size_t(c.joint)]) return 0;
    return c.sign * looks_[std::size_t(c.row)].unit.dot(looks_[std::size_t(c.column)].unit);
  }

  const BlockTree& tree_;
  std::vector<std::unique_ptr<BlockElimination>> eliminations_;  ///< of rings when needed (nblock)
  std::vector<std::unique_ptr<SparseSystem>> sparse_;            ///< made when needed (nblock)

  // the block at hand
  int index_ = -1;
  CycleBlock block_;
  std::vector<Look> looks_, trial_looks_;  ///< (nbar)
  std::vector<double> multiplier_;         ///< (nbar)
  std::vector<Vec3> trial_;                ///< (njoint)
};

}  // namespace ragdoll
