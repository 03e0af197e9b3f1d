// Block tree: a framework's bridges and cycle blocks, made once. It has no root: a sweep that goes
// outward from any joint meets every block once, by one joint. Private to the block solver.

#pragma once
#include <vector>

#include "ragdoll/framework.h"  // Framework

namespace ragdoll {

/// A cycle block with joints and bars numbered from 0.
struct CycleBlock {
  struct LocalBar {
    int p, q;
    double length;
  };
  struct Link {
    int bar, other;
  };
  /// Two bars that share a joint: an entry below the diagonal of J J^T.
  struct Coupling {
    int row, column;
    int joint;
    double sign;  ///< of the product of the bars' unit vectors from p to q
  };

  std::vector<int> joints;           ///< of the framework, ascending (njoint)
  std::vector<int> bars;             ///< of the framework, breadth-first (nbar)
  std::vector<LocalBar> local_bars;  ///< (nbar)
  std::vector<int> link_begin;       ///< (njoint + 1)
  std::vector<Link> links;           ///< (2 nbar)
  std::vector<Coupling> couplings;   ///< by column, then row
  std::vector<int> first_coupled;    ///< first column of each row of J J^T (nbar)
  double mean_length = 0;

  int local(int joint) const;  ///< number of a framework's joint, which must be in the block
};

/// All fixed joints of a component count as held by one rigid piece, the ground, so that what lies
/// between two of them is a cycle block too.
struct BlockTree {
  explicit BlockTree(const Framework& framework);

  std::vector<int> block_of_bar;  ///< -1: a bridge (nbar)
  std::vector<CycleBlock> blocks;
  std::vector<int> ground;  ///< a fixed joint of each component, or -1 (ncomponent)
};

}  // namespace ragdoll
