#include "noncovalent.h"

#include <algorithm>  // all_of, find, max, min, sort, unique
#include <cmath>      // cos, sqrt
#include <numbers>    // pi
#include <utility>    // pair, swap

#include "chemistry_rules.h"          // is_metal, covalent_radius
#include "ragdoll/cell_list.h"        // CellList
#include "ragdoll/place_hydrogens.h"  // place_hydrogens

namespace ragdoll {
namespace {

constexpr int H = 1, N = 7, O = 8, S = 16;

/// The side of a triangle across from an angle, given by its cosine.
double far_side(double one, double other, double cosine) {
  return std::sqrt(std::max(0.0, one * one + other * other - 2 * one * other * cosine));
}

/// The side that makes the angle between it and `one` as small as allowed when the side across from
/// the angle is `across`.
double longest_side(double one, double across, double cosine) {
  const double square = across * across - one * one * (1 - cosine * cosine);
  return one * cosine + std::sqrt(std::max(0.0, square));
}

/// Holds hydrogen bonds and salt bridges by distances, so that they stay what they are by the
/// criteria that found them.
class BondHolder {
 public:
  /// @param molecule  with the hydrogens
  /// @param atoms     of it that the framework has; hydrogens beyond them are not held themselves
  BondHolder(const Molecule& molecule, int atoms, const ConstraintOptions& options,
             const Conformations& conformations, BoundList& bounds)
      : molecule_(molecule),
        atoms_(atoms),
        options_(options),
        conformations_(conformations),
        bounds_(bounds) {}

  /// @return false if a conformation does not have the bond
  bool hold(const HydrogenBond& bond) {
    return bond.hydrogen < atoms_ ? hold_hydrogen(bond) : hold_heavy(bond);
  }

 private:
  /// The hydrogen may move away from the acceptor and the angles may close, as far as distance and
  /// angles stay within the criteria whatever the others do. An angle at the hydrogen cannot close
  /// further than to its least while hydrogen and acceptor are at most `bound` apart, and donor and
  /// acceptor at least as far as a triangle with that bound and that angle has them.
  bool hold_hydrogen(const HydrogenBond& bond) {
    const double dh = distance(bond.donor, bond.hydrogen);
    const double cosine = cosine_of(options_.hydrogen_bond.least_angle_degree);
    const HydrogenBondReach reach = reach_of(bond);
    double most = std::min(reach.hydrogen_acceptor, reach.donor_acceptor - dh);
    most = std::min(most, longest_side(dh, bond.donor_acceptor, cosine));
    const int base = bond.salt_bridge ? -1 : base_of(bond.acceptor, bond.hydrogen);
    const double base_cosine = cosine_of(options_.hydrogen_bond.least_base_angle_degree);
    if (base >= 0)
      most = std::min(most, longest_side(distance(bond.acceptor, base),
                                         distance(bond.hydrogen, base), base_cosine));
    const double bound = with_room(bond.hydrogen_acceptor, most);
    if (conformations_.longest(bond.hydrogen, bond.acceptor) > bound) return false;
    bounds_.tether(bond.hydrogen, bond.acceptor, bound, tether_kind(bond));
    at_least(bond.donor, bond.acceptor, far_side(dh, bound, cosine), contact_kind(bond));
    if (base >= 0)
      at_least(bond.hydrogen, base, far_side(distance(bond.acceptor, base), bound, base_cosine),
               contact_kind(bond));
    return true;
  }

  /// Without its hydrogen: donor and acceptor stay near, and the acceptor stays on the side of the
  /// donor where the hydrogen would be, the donor on the side of the acceptor's pair.
  bool hold_heavy(const HydrogenBond& bond) {
    const double bound = with_room(bond.donor_acceptor, reach_of(bond).donor_acceptor);
    if (conformations_.longest(bond.donor, bond.acceptor) > bound) return false;
    bounds_.tether(bond.donor, bond.acceptor, bound, tether_kind(bond));
    const auto open = [&](int centre, int neighbour, int other) {
      // a right angle
      at_least(neighbour, other, far_side(distance(centre, neighbour), bound, 0),
               contact_kind(bond));
    };
    for (const auto& [neighbour, unused] : molecule_.neighbours(bond.donor))
      if (element(neighbour) != H) open(bond.donor, neighbour, bond.acceptor);
    const int base = bond.salt_bridge ? -1 : base_of(bond.acceptor, bond.donor);
    if (base >= 0) open(bond.acceptor, base, bond.donor);
    return true;
  }

  int element(int atom) const { return molecule_.atoms()[std::size_t(atom)].element; }
  const Vec3& at(int atom) const { return molecule_.positions()[std::size_t(atom)]; }
  double distance(int p, int q) const { return (at(q) - at(p)).norm(); }
  static double cosine_of(double degrees) { return std::cos(degrees * std::numbers::pi / 180); }

  static TetherKind tether_kind(const HydrogenBond& bond) {
    return bond.salt_bridge ? TetherKind::salt_bridge : TetherKind::hydrogen_bond;
  }
  static ContactKind contact_kind(const HydrogenBond& bond) {
    return bond.salt_bridge ? ContactKind::salt_bridge : ContactKind::hydrogen_bond;
  }

  HydrogenBondReach reach_of(const HydrogenBond& bond) const {
    if (bond.salt_bridge) return options_.hydrogen_bond.salt_bridge;
    const bool sulfur = element(bond.donor) == S || element(bond.acceptor) == S;
    return sulfur ? options_.hydrogen_bond.with_sulfur : options_.hydrogen_bond.usual;
  }

  double with_room(double present, double most) const {
    return present + options_.hydrogen_bond_room * std::max(0.0, most - present);
  }

  /// Never more than there is in a conformation.
  void at_least(int p, int q, double length, ContactKind kind) {
    bounds_.contact(p, q, std::min(length, conformations_.shortest(p, q)), kind);
  }

  /// The neighbour of the acceptor that is farthest from the other atom; -1: none.
  int base_of(int acceptor, int other) const {
    int base = -1;
    for (const auto& [neighbour, unused] : molecule_.neighbours(acceptor))
      if (neighbour < atoms_ &&
          (base < 0 || cosine_at(acceptor, neighbour, other) < cosine_at(acceptor, base, other)))
        base = neighbour;
    return base;
  }
  double cosine_at(int centre, int p, int q) const {
    return (at(p) - at(centre)).normalized().dot((at(q) - at(centre)).normalized());
  }

  const Molecule& molecule_;
  int atoms_;
  const ConstraintOptions& options_;
  const Conformations& conformations_;
  BoundList& bounds_;
};

void add_hydrogen_bonds(const Molecule& molecule, const ConstraintOptions& options,
                        const Conformations& conformations, FrameworkParts& parts,
                        BoundList& bounds) {
  const int atoms = int(molecule.atoms().size());
  const Molecule whole = options.place_hydrogens ? place_hydrogens(molecule) : molecule;
  BondHolder holder(whole, atoms, options, conformations, bounds);
  const auto counts = [&](int atom) {
    return options.solvent_hydrogen_bonds || !is_water(molecule, atom);
  };
  for (const HydrogenBond& bond : hydrogen_bonds(whole, options.hydrogen_bond)) {
    if (!counts(bond.donor) || !counts(bond.acceptor) || !holder.hold(bond)) continue;
    const int hydrogen = bond.hydrogen < atoms ? bond.hydrogen : -1;
    parts.held_bonds.push_back(
        {bond.donor, hydrogen, bond.acceptor, bond.energy, bond.salt_bridge});
  }
}

/// One bound for each pair, in the order of their joints.
template <class Pair, class Tighter>
std::vector<Pair> tightest(std::vector<Pair> all, const Tighter& tighter) {
  std::stable_sort(all.begin(), all.end(), [&](const Pair& a, const Pair& b) {
    if (a.p != b.p || a.q != b.q) return std::pair(a.p, a.q) < std::pair(b.p, b.q);
    return tighter(a.length, b.length);
  });
  const auto same = [](const Pair& a, const Pair& b) { return a.p == b.p && a.q == b.q; };
  all.erase(std::unique(all.begin(), all.end(), same), all.end());
  return all;
}

}  // namespace

// === Bounds

void BoundList::put_into(FrameworkParts& parts) const {
  parts.tethers = tightest(tethers_, [](double a, double b) { return a < b; });
  parts.contacts = tightest(contacts_, [](double a, double b) { return a > b; });
}

bool BoundList::has_bar(int p, int q) const {
  const std::vector<int>& partners = barred_[std::size_t(std::min(p, q))];
  return std::find(partners.begin(), partners.end(), std::max(p, q)) != partners.end();
}

void BoundList::tether(int p, int q, double length, TetherKind kind) {
  if (has_bar(p, q)) return;
  tethers_.push_back({std::min(p, q), std::max(p, q), length, kind});
}

void BoundList::contact(int p, int q, double length, ContactKind kind) {
  if (has_bar(p, q)) return;
  contacts_.push_back({std::min(p, q), std::max(p, q), length, kind});
}

// === What is held

bool is_water(const Molecule& molecule, int oxygen) {
  if (molecule.atoms()[std::size_t(oxygen)].element != O) return false;
  const auto& around = molecule.neighbours(oxygen);
  return std::all_of(around.begin(), around.end(), [&](const Molecule::Neighbour& neighbour) {
    return molecule.atoms()[std::size_t(neighbour.atom)].element == H;
  });
}

std::vector<std::pair<int, int>> metal_bonds(const Molecule& molecule, double slack) {
  std::vector<int> atoms;
  std::vector<Vec3> positions;
  double largest = 0;
  int metals = 0;
  for (int i = 0; i < int(molecule.atoms().size()); ++i) {
    const int element = molecule.atoms()[std::size_t(i)].element;
    const bool donor = element == N || element == O || element == S;
    if (!is_metal(element) && (!donor || is_water(molecule, i))) continue;
    metals += is_metal(element);
    atoms.push_back(i);
    positions.push_back(molecule.positions()[std::size_t(i)]);
    largest = std::max(largest, covalent_radius(element));
  }
  std::vector<std::pair<int, int>> bonds;
  if (metals == 0) return bonds;
  std::vector<CellPair> pairs;
  const CellList cells(positions, 2 * largest + slack, nullptr);
  for (std::size_t cell = 0; cell < cells.cell_count(); ++cell) cells.find_candidates(cell, pairs);
  for (const CellPair& pair : pairs) {
    int metal = atoms[std::size_t(pair.p)], donor = atoms[std::size_t(pair.q)];
    const auto element = [&](int i) { return molecule.atoms()[std::size_t(i)].element; };
    if (!is_metal(element(metal))) std::swap(metal, donor);
    if (!is_metal(element(metal)) || is_metal(element(donor))) continue;
    const double distance =
        (positions[std::size_t(pair.q)] - positions[std::size_t(pair.p)]).norm();
    if (distance > covalent_radius(element(metal)) + covalent_radius(element(donor)) + slack)
      continue;
    // a positive nitrogen has given its pair away
    if (molecule.atoms()[std::size_t(donor)].formal_charge > 0) continue;
    bonds.emplace_back(metal, donor);
  }
  std::sort(bonds.begin(), bonds.end());
  return bonds;
}

void add_noncovalent(const Molecule& molecule, const ConstraintOptions& options,
                     const Conformations& conformations, FrameworkParts& parts, BoundList& bounds) {
  if (options.hydrogen_bonds) add_hydrogen_bonds(molecule, options, conformations, parts, bounds);
  if (options.hydrophobic)
    for (const HydrophobicTether& t : hydrophobic_tethers(molecule, options.hydrophobic_tether))
      if (conformations.longest(t.a, t.b) <= t.bound)
        bounds.tether(t.a, t.b, t.bound, TetherKind::hydrophobic);
  if (options.stacking)
    for (const StackedPair& pair : stacked_rings(molecule, options.stacked_ring))
      if (conformations.longest(pair.a, pair.b) <= pair.bound)
        bounds.tether(pair.a, pair.b, pair.bound, TetherKind::stacking);
  for (const Tether& t : options.tethers) bounds.tether(t.p, t.q, t.length, TetherKind::user);
  for (const Contact& c : options.contacts) bounds.contact(c.p, c.q, c.length, ContactKind::user);
}

}  // namespace ragdoll
