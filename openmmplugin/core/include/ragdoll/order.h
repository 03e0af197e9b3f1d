// Order: which bar is resolved when, and from which end.

#pragma once
#include <span>
#include <string>
#include <vector>

#include "ragdoll/graph.h"   // Graph
#include "ragdoll/random.h"  // Random

namespace ragdoll {

enum class OrderKind {
  random,
  bfs_tree,
  dfs_tree,
  bfs_cycle,
  dfs_cycle,
  bfs_reverse,
  dfs_reverse,
  bfs_adapt,
  bfs_random,
  // ours
  bfs_active,  ///< bfs_cycle, but visits only bars of which an end moved since their last visit
  bfs_worst,   ///< the same; later iterations start from the bar that is violated most
};

/// @throw Error on an unknown name; the sentence lists the known ones
OrderKind order_kind(const std::string& name);
std::string name_of(OrderKind kind);

/// All names, the thesis' first.
std::vector<std::string> order_names();

/// One visit of a bar: `near` is the end nearer the root in the traversal.
struct Visit {
  int bar = 0, near = 0, far = 0;
  bool problem = false;  ///< outside the traversal's spanning tree: it closes a cycle
};

using Order = std::vector<Visit>;

/// The order of the first iteration. Several roots: the component of the first root comes first,
/// the others follow in joint order, each from its own root, or from its lowest joint where it has
/// none. A problem constraint's nearer end is the one with the smaller depth in the traversal; on
/// ties the bar's first joint. The tree orders leave problem constraints out. Only `random` uses
/// `random`.
/// @throw Error if a root is no joint
Order order_of(const Graph& graph, OrderKind kind, std::span<const int> roots, Random& random);

/// @throw Error if a root is no joint
void check_roots(const Graph& graph, std::span<const int> roots);

/// Random order: the bars shuffled; near is the bar's first joint.
Order shuffled_order(const Graph& graph, Random& random);

/// bfs_adapt's later iterations: from the problem constraint that was corrected last; bfs_worst's:
/// from the bar that is violated most. That bar comes first, as a problem constraint.
Order adapted_order(const Graph& graph, int problem_bar, std::span<const int> roots);

}  // namespace ragdoll
