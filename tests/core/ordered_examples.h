// Ordered examples: what the tests of solver ordered share.

#pragma once
#include <algorithm>  // max
#include <cmath>      // abs
#include <initializer_list>
#include <limits>
#include <vector>

#include "examples.h"          // Positions
#include "ragdoll/resolver.h"  // make_resolver

namespace ragdoll::examples {

inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();
inline constexpr double infinity = std::numeric_limits<double>::infinity();

inline const Weighting even = {0.5, 0.5}, uneven = {0.25, 0.75}, far_only = {0, 1};
inline const Weighting weightings[] = {even, uneven, far_only};

inline constexpr OrderKind all_kinds[] = {
    OrderKind::random,      OrderKind::bfs_tree,  OrderKind::dfs_tree,
    OrderKind::bfs_cycle,   OrderKind::dfs_cycle, OrderKind::bfs_reverse,
    OrderKind::dfs_reverse, OrderKind::bfs_adapt, OrderKind::bfs_random};

inline bool is_tree_order(OrderKind kind) {
  return kind == OrderKind::bfs_tree || kind == OrderKind::dfs_tree;
}

inline Random dice(std::uint64_t seed) {
  return Random(seed, RandomStream::generate, 0);
}

inline ResolveReport resolve(const FrameworkParts& parts, Positions& x, ResolverSettings settings,
                             const std::vector<int>& roots = {}, std::uint64_t step = 0) {
  settings.solver = "ordered";
  return make_resolver(framework_of(parts), settings)->resolve(x, {.roots = roots, .step = step});
}

inline double worst_of(const FrameworkParts& parts, const Positions& x) {
  double worst = 0;
  for (const Bar& bar : parts.bars) {
    const double d = (x[std::size_t(bar.q)] - x[std::size_t(bar.p)]).norm();
    worst = std::max(worst, std::abs(d - bar.length) / bar.length);
  }
  return worst;
}

/// Three joints on a line, bars of length 1, and joint a pulled away by 1.
struct PulledChain {
  FrameworkParts parts = parts_of("ab bc", {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}});
  Positions x = {{-1, 0, 0}, {1, 0, 0}, {2, 0, 0}};
};

/// Positions on the x axis.
inline Positions on_axis(std::initializer_list<double> values) {
  Positions x;
  for (const double value : values) x.emplace_back(value, 0, 0);
  return x;
}

}  // namespace ragdoll::examples
