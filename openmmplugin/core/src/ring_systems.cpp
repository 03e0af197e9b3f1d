#include "ragdoll/ring_systems.h"

#include <algorithm>  // max_element, min
#include <numeric>    // iota
#include <utility>    // pair

#include "disjoint_sets.h"  // DisjointSets

namespace ragdoll {
namespace {

bool closes_rings(const Molecule& molecule, int bond) {
  return molecule.bonds()[std::size_t(bond)].order != BondOrder::dative;
}

/// Whether a bond is in a ring: those that a depth-first search does not find to be bridges.
class RingBonds {
 public:
  explicit RingBonds(const Molecule& molecule)
      : molecule_(molecule),
        found_(molecule.atoms().size(), -1),
        low_(molecule.atoms().size()),
        in_ring(molecule.bonds().size(), 1) {
    for (std::size_t k = 0; k < molecule.bonds().size(); ++k)
      if (!closes_rings(molecule, int(k))) in_ring[k] = 0;
    for (int atom = 0; atom < int(molecule.atoms().size()); ++atom)
      if (found_[std::size_t(atom)] < 0) search(atom);
  }

 private:
  struct Visit {
    int atom, bond;        ///< the bond it was reached by
    std::size_t next = 0;  ///< neighbour
  };

  void search(int start) {
    std::vector<Visit> path = {{start, -1}};
    enter(start);
    while (!path.empty()) {
      const int atom = path.back().atom, came_by = path.back().bond;
      const auto& around = molecule_.neighbours(atom);
      if (path.back().next < around.size()) {
        const auto [other, bond] = around[path.back().next++];
        if (bond == came_by || !closes_rings(molecule_, bond)) continue;
        if (found_[std::size_t(other)] >= 0) {
          lower(atom, found_[std::size_t(other)]);
        } else {
          enter(other);
          path.push_back({other, bond});
        }
        continue;
      }
      path.pop_back();
      if (path.empty()) break;
      const int before = path.back().atom;
      lower(before, low_[std::size_t(atom)]);
      if (low_[std::size_t(atom)] > found_[std::size_t(before)]) in_ring[std::size_t(came_by)] = 0;
    }
  }

  void enter(int atom) { found_[std::size_t(atom)] = low_[std::size_t(atom)] = count_++; }
  void lower(int atom, int value) {
    low_[std::size_t(atom)] = std::min(low_[std::size_t(atom)], value);
  }

  const Molecule& molecule_;
  std::vector<int> found_, low_;  ///< (natom)
  int count_ = 0;

 public:
  std::vector<unsigned char> in_ring;  ///< (nbond)
};

/// Breadth first around the ring bonds, without the bond itself.
int smallest_ring(const Molecule& molecule, const std::vector<unsigned char>& in_ring, int bond,
                  std::vector<int>& distance) {
  const Bond& of = molecule.bonds()[std::size_t(bond)];
  std::vector<int> queue = {of.a};
  distance[std::size_t(of.a)] = 1;
  for (std::size_t k = 0; k < queue.size() && distance[std::size_t(of.b)] == 0; ++k)
    for (const auto& [other, by] : molecule.neighbours(queue[k])) {
      if (by == bond || !in_ring[std::size_t(by)] || distance[std::size_t(other)] > 0) continue;
      distance[std::size_t(other)] = distance[std::size_t(queue[k])] + 1;
      queue.push_back(other);
    }
  const int size = distance[std::size_t(of.b)];
  for (const int atom : queue) distance[std::size_t(atom)] = 0;
  return size;
}

}  // namespace

int RingSystem::largest_ring() const {
  return ring_size.empty() ? 0 : *std::max_element(ring_size.begin(), ring_size.end());
}

std::vector<RingSystem> ring_systems(const Molecule& molecule) {
  const RingBonds rings(molecule);
  const std::size_t n = molecule.atoms().size();
  DisjointSets sets(static_cast<int>(n));
  std::vector<unsigned char> is_ring_atom(n);
  for (std::size_t k = 0; k < molecule.bonds().size(); ++k) {
    if (!rings.in_ring[k]) continue;
    const Bond& bond = molecule.bonds()[k];
    sets.join(bond.a, bond.b);
    is_ring_atom[std::size_t(bond.a)] = is_ring_atom[std::size_t(bond.b)] = 1;
  }
  std::vector<RingSystem> systems;
  std::vector<int> number(n, -1), distance(n, 0);
  for (int atom = 0; atom < int(n); ++atom) {
    if (!is_ring_atom[std::size_t(atom)]) continue;
    int& of = number[std::size_t(sets.find(atom))];
    if (of < 0) {
      of = int(systems.size());
      systems.emplace_back();
    }
    systems[std::size_t(of)].atoms.push_back(atom);
  }
  for (std::size_t k = 0; k < molecule.bonds().size(); ++k) {
    if (!rings.in_ring[k]) continue;
    const int of = number[std::size_t(sets.find(molecule.bonds()[k].a))];
    RingSystem& system = systems[std::size_t(of)];
    system.bonds.push_back(int(k));
    system.ring_size.push_back(smallest_ring(molecule, rings.in_ring, int(k), distance));
  }
  return systems;
}

}  // namespace ragdoll
