// Block Newton: resolves one cycle block with some of its joints pinned. Private to the block
// solver.

#pragma once
#include <Eigen/SparseCholesky>  // SimplicialLDLT
#include <cmath>                 // abs
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "block_tree.h"    // CycleBlock
#include "ragdoll/vec3.h"  // Vec3

namespace ragdoll {

/// Least-norm Newton steps, damped as Levenberg and Marquardt do: dx = -J^T (J J^T + mu)^-1 c, with
/// c = |q - p| - length. Dense for few bars, else sparse; the sparse pattern is analysed once.
class BlockNewton {
 public:
  BlockNewton(const CycleBlock& block, double tolerance);

  /// Moves the joints until all bars are within half the tolerance, so that rounding elsewhere does
  /// not break them again. What cannot be met is left where it is nearest.
  /// @param x       positions (njoint of the block)
  /// @param pinned  1: does not move (njoint of the block)
  /// @return true if all bars are within the tolerance
  bool resolve(std::span<Vec3> x, std::span<const std::uint8_t> pinned, double first_mu);

  /// Largest relative violation; evaluates `x` for the rest of the class.
  double worst(std::span<const Vec3> x);

  /// Relative violation of a bar at the positions evaluated last: where resolve() left them.
  double violation(std::size_t bar) const {
    return std::abs(error_[Eigen::Index(bar)]) / block_.local_bars[bar].length;
  }

  std::int64_t visits = 0;  ///< bars looked at, in total

 private:
  using Sparse = Eigen::SparseMatrix<double>;
  struct SparseSystem {
    Sparse matrix;               ///< lower triangle of J J^T + mu
    std::vector<int> diagonal;   ///< where its entries are in the matrix' values (nbar)
    std::vector<int> couplings;  ///< the same of the couplings
    Eigen::SimplicialLDLT<Sparse> solver;
  };

  void analyse();
  bool solve(std::span<const std::uint8_t> pinned, double mu);
  bool solve_dense(std::span<const std::uint8_t> pinned, double mu);
  bool solve_sparse(std::span<const std::uint8_t> pinned, double mu);

  double diagonal(std::size_t bar, std::span<const std::uint8_t> pinned) const {
    const auto& b = block_.local_bars[bar];
    return double(!pinned[std::size_t(b.p)]) + double(!pinned[std::size_t(b.q)]);
  }
  double coupling(const CycleBlock::Coupling& c, std::span<const std::uint8_t> pinned) const {
    if (pinned[std::size_t(c.joint)]) return 0;
    return c.sign * unit_[std::size_t(c.row)].dot(unit_[std::size_t(c.column)]);
  }

  const CycleBlock& block_;
  double tolerance_, inside_;
  double merit_ = 0;            ///< sum of squared errors at the positions evaluated last
  std::vector<Vec3> unit_;      ///< from p to q (nbar)
  Eigen::VectorXd error_;       ///< (nbar)
  Eigen::VectorXd multiplier_;  ///< (nbar)
  std::vector<Vec3> trial_;     ///< (njoint)
  std::vector<double> dense_;   ///< (nbar, nbar)
  std::unique_ptr<SparseSystem> sparse_;
};

}  // namespace ragdoll
