// Classify: what a framework is made of, by its block-cut decomposition: bridges, which hang one
// part on another, and cycle blocks, which close on themselves. Linear in joints and bars.

#pragma once
#include <string>
#include <vector>

#include "ragdoll/graph.h"  // Graph

namespace ragdoll {

/// A cycle block: a largest set of bars in which any two lie on a common cycle.
struct Block {
  std::vector<int> joints;  ///< ascending
  std::vector<int> bars;    ///< ascending
  int component = 0;
  int cycle_rank() const { return int(bars.size()) - int(joints.size()) + 1; }
};

struct ComponentClass {
  std::string class_name;  ///< "tree", "1-cycle", "2-cycle" or "n-cycle"
  std::string type;        ///< of a 2-cycle: "path", "shared-joint" or "theta"; of others empty
  int lowest_joint = 0;
  int joints = 0, bars = 0, cycle_rank = 0;
  int diameter = 0;  ///< bars from end to end, by two breadth-first searches: exact on trees, else
                     ///< a lower bound
};

struct Classification {
  std::string class_name, type;            ///< of the largest component (the first of them on ties)
  int diameter = 0;                        ///< of the largest component
  int cycle_rank = 0;                      ///< of all components together
  std::vector<ComponentClass> components;  ///< in the order of their lowest joints
  std::vector<int> bridges;                ///< bars on no cycle, ascending
  std::vector<int> articulation_joints;    ///< where parts hang together, ascending
  std::vector<Block> blocks;               ///< in the order of their lowest bars
};

Classification classify(const Graph& graph);

}  // namespace ragdoll
