#include "ragdoll/hydrophobic_tethers.h"

#include <algorithm>  // all_of, max, sort
#include <cmath>      // isfinite
#include <utility>    // pair

#include "chemistry_rules.h"    // van_der_waals_radius
#include "ragdoll/cell_list.h"  // CellList
#include "ragdoll/error.h"      // Error

namespace ragdoll {
namespace {

constexpr int H = 1, C = 6, S = 16;

bool is_hydrophobic(const Molecule& molecule, int atom) {
  const auto element = [&](int i) { return molecule.atoms()[std::size_t(i)].element; };
  if (element(atom) != C && element(atom) != S) return false;
  const auto& around = molecule.neighbours(atom);
  return std::all_of(around.begin(), around.end(), [&](const Molecule::Neighbour& neighbour) {
    const int e = element(neighbour.atom);
    return e == H || e == C || e == S;
  });
}

/// Tells which atoms are at most three bonds from one atom.
class Near {
 public:
  explicit Near(const Molecule& molecule)
      : molecule_(molecule), mark_(molecule.atoms().size(), -1) {}

  void around(int atom) {
    center_ = atom;
    mark_[std::size_t(atom)] = atom;
    ring_.assign(1, atom);
    for (std::size_t head = 0, bonds = 0; bonds < 3; ++bonds)
      for (const std::size_t end = ring_.size(); head < end; ++head)
        for (const auto& [other, bond] : molecule_.neighbours(ring_[head]))
          if (mark_[std::size_t(other)] != atom) {
            mark_[std::size_t(other)] = atom;
            ring_.push_back(other);
          }
  }

  bool has(int atom) const { return mark_[std::size_t(atom)] == center_; }

 private:
  const Molecule& molecule_;
  std::vector<int> mark_, ring_;
  int center_ = -1;
};

}  // namespace

std::vector<HydrophobicTether> hydrophobic_tethers(const Molecule& molecule,
                                                   const HydrophobicTetherOptions& options) {
  if (!std::isfinite(options.margin) || !std::isfinite(options.shortest))
    throw Error("the margin and the shortest length of tethers are to be numbers");
  std::vector<int> atoms;
  std::vector<Vec3> positions;
  double largest = 0;
  for (int i = 0; i < int(molecule.atoms().size()); ++i) {
    if (!is_hydrophobic(molecule, i)) continue;
    atoms.push_back(i);
    positions.push_back(molecule.positions()[std::size_t(i)]);
    largest = std::max(largest, van_der_waals_radius(molecule.atoms()[std::size_t(i)].element));
  }
  std::vector<HydrophobicTether> tethers;
  const double reach = 2 * largest + options.margin;
  if (atoms.empty() || reach <= 0) return tethers;

  // a cell list gives what is closer than its cutoff, and a few more, in any order
  std::vector<CellPair> pairs;
  const CellList cells(positions, reach * (1 + 1e-9), nullptr);
  for (std::size_t cell = 0; cell < cells.cell_count(); ++cell) cells.find_candidates(cell, pairs);
  std::sort(pairs.begin(), pairs.end(), [](const CellPair& one, const CellPair& other) {
    return std::pair(one.p, one.q) < std::pair(other.p, other.q);
  });
  Near near(molecule);
  int last = -1;
  for (const auto& [p, q, unused] : pairs) {
    const int a = atoms[std::size_t(p)], b = atoms[std::size_t(q)];
    if (p != last) near.around(a);
    last = p;
    const double bound = van_der_waals_radius(molecule.atoms()[std::size_t(a)].element) +
                         van_der_waals_radius(molecule.atoms()[std::size_t(b)].element) +
                         options.margin;
    const double distance = (positions[std::size_t(q)] - positions[std::size_t(p)]).norm();
    if (distance <= bound && distance >= options.shortest && !near.has(b))
      tethers.push_back({a, b, distance, bound});
  }
  return tethers;
}

}  // namespace ragdoll
