// A second statement of classification, by definition and without regard to time: what core's
// linear one is held against.

#pragma once
#include <algorithm>  // max
#include <numeric>    // iota
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace ragdoll::naive {

using Bars = std::vector<std::pair<int, int>>;

/// Components among the joints that are not left out, over the bars that are not.
inline int component_count(int joints, const Bars& bars, int without_bar = -1,
                           int without_joint = -1) {
  std::vector<int> label(static_cast<std::size_t>(joints));
  std::iota(label.begin(), label.end(), 0);
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t k = 0; k < bars.size(); ++k) {
      const auto [p, q] = bars[k];
      if (int(k) == without_bar || p == without_joint || q == without_joint) continue;
      int &a = label[std::size_t(p)], &b = label[std::size_t(q)];
      if (a == b) continue;
      a = b = std::min(a, b);
      changed = true;
    }
  }
  std::set<int> labels;
  for (int j = 0; j < joints; ++j)
    if (j != without_joint) labels.insert(label[std::size_t(j)]);
  return int(labels.size());
}

inline int cycle_rank(int joints, const Bars& bars) {
  return int(bars.size()) - joints + component_count(joints, bars);
}

inline bool is_bridge(int joints, const Bars& bars, int bar) {
  return component_count(joints, bars, bar) > component_count(joints, bars);
}

/// "tree", "1-cycle", ... of a connected graph.
inline std::string class_of(int joints, const Bars& bars) {
  const int rank = cycle_rank(joints, bars);
  return rank == 0 ? "tree" : rank < 3 ? std::to_string(rank) + "-cycle" : "n-cycle";
}

/// Type of a connected 2-cycle: cut off all ends that hang free. One joint with four bars is left,
/// or two with three; in the latter case a bridge between them tells a path from a theta.
inline std::string type_of(int joints, Bars bars) {
  if (cycle_rank(joints, bars) != 2) return "";
  std::vector<int> degree;
  for (bool changed = true; changed;) {
    degree.assign(std::size_t(joints), 0);
    for (const auto& [p, q] : bars) ++degree[std::size_t(p)], ++degree[std::size_t(q)];
    changed = std::erase_if(bars, [&](const auto& bar) {
                return degree[std::size_t(bar.first)] == 1 || degree[std::size_t(bar.second)] == 1;
              }) > 0;
  }
  if (*std::max_element(degree.begin(), degree.end()) == 4) return "shared-joint";
  for (int k = 0; k < int(bars.size()); ++k)
    if (is_bridge(joints, bars, k)) return "path";
  return "theta";
}

/// Longest of all shortest paths of a connected graph (Floyd & Warshall).
inline int diameter_of(int joints, const Bars& bars) {
  const std::size_t n = std::size_t(joints);
  std::vector<std::vector<int>> d(n, std::vector<int>(n, joints));
  for (std::size_t j = 0; j < n; ++j) d[j][j] = 0;
  for (const auto& [p, q] : bars)
    d[std::size_t(p)][std::size_t(q)] = d[std::size_t(q)][std::size_t(p)] = 1;
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) d[i][j] = std::min(d[i][j], d[i][k] + d[k][j]);
  int longest = 0;
  for (const auto& row : d)
    for (const int distance : row) longest = std::max(longest, distance);
  return longest;
}

/// Sets of bars that lie on common cycles: those that no joint taken away parts from each other.
inline std::set<std::set<int>> cycle_blocks(int joints, const Bars& bars) {
  const std::size_t m = bars.size();
  // together[a][b]: whatever joint is taken away, what is left of a and b stays connected
  std::vector<std::vector<bool>> together(m, std::vector<bool>(m, true));
  for (int cut = -1; cut < joints; ++cut) {
    std::vector<int> label(static_cast<std::size_t>(joints));
    std::iota(label.begin(), label.end(), 0);
    for (bool changed = true; changed;) {
      changed = false;
      for (const auto& [p, q] : bars) {
        int &a = label[std::size_t(p)], &b = label[std::size_t(q)];
        if (p == cut || q == cut || a == b) continue;
        a = b = std::min(a, b);
        changed = true;
      }
    }
    const auto side = [&](std::size_t k) {
      const auto [p, q] = bars[k];
      return label[std::size_t(p == cut ? q : p)];
    };
    for (std::size_t a = 0; a < m; ++a)
      for (std::size_t b = 0; b < m; ++b)
        if (side(a) != side(b)) together[a][b] = false;
  }
  std::set<std::set<int>> blocks;
  for (std::size_t a = 0; a < m; ++a) {
    std::set<int> block;
    for (std::size_t b = 0; b < m; ++b)
      if (together[a][b]) block.insert(int(b));
    if (block.size() > 1) blocks.insert(block);
  }
  return blocks;
}

}  // namespace ragdoll::naive
