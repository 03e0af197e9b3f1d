// Newton bars plan: what a framework of bars whose cycles are few decides once for NewtonBars, the
// order in which bars are eliminated and the program by which they are. Private to the resolvers.

#pragma once
#include <cstddef>
#include <memory>
#include <vector>

#include "ragdoll/resolver.h"  // Framework, ResolverSettings

namespace ragdoll {

/// Unknown is one multiplier for each bar, coupled to those of the bars that it shares a joint
/// with. Bars are eliminated inward, from the leaves of a breadth-first tree to a middle joint, so
/// that a tree's multipliers couple no others than at first.
struct NewtonBarsPlan {
  /// @return null where constraints are no bars, or cycles would couple too many of them
  static std::shared_ptr<const NewtonBarsPlan> make(const Framework& framework,
                                                    const ResolverSettings& settings);

  struct BarRow {
    int p, q;
    double length;
    double near_weight, far_weight;  ///< of p and q: 0 where fixed, else 1 or the inverse mass
  };
  /// Of the matrix, below its diagonal. Bars are rows and columns.
  struct Entry {
    int row, column;
    double coupling;  ///< the shared joint's weight, signed: how it multiplies the bars' vectors;
                      ///< 0: it comes about by elimination alone
  };

  std::size_t joint_count = 0;
  std::vector<BarRow> bars;    ///< in the order of elimination (nbar)
  std::vector<Entry> entries;  ///< column after column, rows ascending
  std::vector<int> begin;      ///< first entry of each column (nbar + 1)
  /// Values that the products of a column's entries are taken from, in turn: of each pair of
  /// entries, the later first. Values are the diagonal, then the entries.
  std::vector<int> targets;

 private:
  bool order_bars(const Framework& framework, const ResolverSettings& settings);
  bool fill_in();
};

}  // namespace ragdoll
