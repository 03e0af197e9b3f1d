// Block elimination: LDL^T of J J^T of a cycle block of few bars, by a program that is worked out
// once from which bars share a joint. Private to the block solver.

#pragma once
#include <vector>

#include "block_tree.h"  // CycleBlock

namespace ragdoll {

/// Bars with the fewest neighbours are eliminated first, and of these the ones whose neighbours
/// were not touched for longest: along a chain every other one, so that one does not wait for the
/// next.
class BlockElimination {
 public:
  /// Whether the block is small, and its bars have few neighbours; else this would take long.
  static bool suits(const CycleBlock& block);

  explicit BlockElimination(const CycleBlock& block);

  /// Solves (J J^T + mu) y = c.
  /// @param diagonal  of J J^T, by a bar
  /// @param coupling  entry of J J^T, by a place in the block's couplings
  /// @param right     c, by a bar
  /// @param y         by a bar (nbar)
  /// @return false where it is not positive definite
  template <class Diagonal, class Coupling, class Right>
  bool solve(double mu, Diagonal diagonal, Coupling coupling, Right right, double* y) {
    const std::size_t n = bar_.size();
    double* const v = value_.data();
    double* const z = solution_.data();
    const int* const row = row_.data();
    for (std::size_t i = 0; i < n; ++i) {
      v[i] = diagonal(std::size_t(bar_[i])) + mu;
      z[i] = right(std::size_t(bar_[i]));
    }
    for (const int entry : fill_) v[entry] = 0;
    for (std::size_t k = 0; k < entry_of_.size(); ++k) v[entry_of_[k]] = coupling(k);
    const int* target = target_.data();
    for (std::size_t j = 0; j < n; ++j) {
      if (!(v[j] > 0)) return false;
      const double inverse = v[j] = 1 / v[j];
      for (int e = begin_[j]; e < begin_[j + 1]; ++e) {
        const double factor = v[e] * inverse;
        z[row[e]] -= factor * z[j];
        for (int g = begin_[j]; g <= e; ++g) v[*target++] -= factor * v[g];
      }
    }
    for (std::size_t j = n; j-- > 0;) {
      double sum = z[j];
      for (int e = begin_[j]; e < begin_[j + 1]; ++e) sum -= v[e] * z[row[e]];
      z[j] = sum * v[j];
      y[bar_[j]] = z[j];
    }
    return true;
  }

 private:
  static constexpr int most_bars = 64;  ///< a bit for each
  static constexpr int most_rows = 11;  ///< of a column, on average

  // values: the diagonal, then columns below it, one after the other
  std::vector<int> bar_;       ///< in the order of elimination (nbar)
  std::vector<int> begin_;     ///< first value of each column (nbar + 1)
  std::vector<int> row_;       ///< of the values
  std::vector<int> entry_of_;  ///< value of each of the block's couplings
  std::vector<int> fill_;      ///< values that no coupling sets
  std::vector<int> target_;    ///< values that the products of a column are taken from, in turn
  std::vector<double> value_, solution_;
};

}  // namespace ragdoll
