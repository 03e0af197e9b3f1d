#include "ragdoll/hinge_tree.h"

#include <algorithm>  // find
#include <utility>    // move

#include "disjoint_sets.h"  // DisjointSets

namespace ragdoll {
namespace {

constexpr int largest_ring = 8;

/// Whether the ends of a bond are joined by a path of other bonds that closes a small ring.
class SmallRings {
 public:
  explicit SmallRings(const Graph& graph)
      : graph_(graph), seen_(std::size_t(graph.joint_count()), -1) {}

  bool hold(int bond) {
    const auto [from, to] = graph_.ends(bond);
    std::vector<int> now = {from}, next;
    seen_[std::size_t(from)] = bond;
    for (int length = 1; length < largest_ring && !now.empty(); ++length) {
      next.clear();
      for (const int joint : now)
        for (const Graph::Link& link : graph_.links(joint)) {
          if (link.bar == bond || seen_[std::size_t(link.other)] == bond) continue;
          if (link.other == to) return true;
          seen_[std::size_t(link.other)] = bond;
          next.push_back(link.other);
        }
      std::swap(now, next);
    }
    return false;
  }

 private:
  const Graph& graph_;
  std::vector<int> seen_;  ///< the bond whose search came by last (njoint)
};

std::vector<std::pair<int, int>> planar_bonds(const Framework& framework) {
  std::vector<std::pair<int, int>> bonds;
  for (const PlanarTorsion& torsion : framework.planar_torsions())
    bonds.emplace_back(std::min(torsion.b, torsion.c), std::max(torsion.b, torsion.c));
  std::sort(bonds.begin(), bonds.end());
  return bonds;
}

std::vector<bool> rotatable_bonds(const Framework& framework) {
  const Graph& graph = framework.bond_graph();
  const std::vector<std::pair<int, int>> planar = planar_bonds(framework);
  SmallRings rings(graph);
  std::vector<bool> rotatable(std::size_t(graph.bar_count()), false);
  for (int bond = 0; bond < graph.bar_count(); ++bond) {
    const auto [a, b] = graph.ends(bond);
    if (graph.links(a).size() < 2 || graph.links(b).size() < 2) continue;
    if (std::binary_search(planar.begin(), planar.end(), std::pair(std::min(a, b), std::max(a, b))))
      continue;
    rotatable[std::size_t(bond)] = !rings.hold(bond);
  }
  return rotatable;
}

}  // namespace

HingeTree::HingeTree(const Framework& framework) {
  const Graph& graph = framework.bond_graph();
  const int count = graph.joint_count();
  const std::vector<bool> rotatable = rotatable_bonds(framework);
  DisjointSets sets(count);
  for (int bond = 0; bond < graph.bar_count(); ++bond)
    if (!rotatable[std::size_t(bond)]) sets.join(graph.ends(bond).first, graph.ends(bond).second);
  std::vector<int> unit_of, sizes;
  sets.number(1, unit_of, sizes);
  std::vector<std::vector<int>> members(sizes.size());
  for (int joint = 0; joint < count; ++joint)
    members[std::size_t(unit_of[std::size_t(joint)])].push_back(joint);

  // depth first over units, by a stack of our own: chains are long
  struct Visit {
    int unit, hinge;                  ///< the hinge that led here; -1: none
    std::size_t joint = 0, link = 0;  ///< where the search for the next hinge goes on
  };
  std::vector<bool> seen(sizes.size(), false);
  std::vector<Visit> stack;
  const auto enter = [&](int unit, int hinge) {
    seen[std::size_t(unit)] = true;
    joints_.insert(joints_.end(), members[std::size_t(unit)].begin(),
                   members[std::size_t(unit)].end());
    stack.push_back({unit, hinge});
  };
  for (int root = 0; root < int(sizes.size()); ++root) {
    if (seen[std::size_t(root)]) continue;
    const int first = int(joints_.size());
    enter(root, -1);
    while (!stack.empty()) {
      Visit& visit = stack.back();
      const std::vector<int>& own = members[std::size_t(visit.unit)];
      if (visit.joint == own.size()) {
        if (visit.hinge >= 0) hinges_[std::size_t(visit.hinge)].last = int(joints_.size());
        stack.pop_back();
        continue;
      }
      const int joint = own[visit.joint];
      const auto links = graph.links(joint);
      if (visit.link == links.size()) {
        ++visit.joint;
        visit.link = 0;
        continue;
      }
      const Graph::Link link = links[visit.link++];
      const int unit = unit_of[std::size_t(link.other)];
      if (!rotatable[std::size_t(link.bar)] || seen[std::size_t(unit)]) continue;
      Hinge hinge;
      hinge.inner = joint;
      hinge.outer = link.other;
      hinge.first = int(joints_.size());
      hinge.parent = visit.hinge;
      hinge.component = int(components_.size());
      hinges_.push_back(hinge);
      enter(unit, int(hinges_.size()) - 1);
    }
    components_.emplace_back(first, int(joints_.size()));
  }
}

}  // namespace ragdoll
