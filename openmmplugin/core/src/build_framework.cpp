#include "ragdoll/build_framework.h"

#include <algorithm>  // any_of, sort, unique, find, clamp
#include <array>
#include <cmath>    // atan2, sin, abs
#include <limits>   // infinity
#include <numbers>  // pi
#include <tuple>    // tie
#include <utility>  // pair, move, exchange

#include "chemistry_rules.h"       // PlanarUnits, van_der_waals_radius
#include "conformations.h"         // Conformations
#include "noncovalent.h"           // add_noncovalent, metal_bonds, BoundList
#include "ragdoll/cell_list.h"     // CellList, CellPair
#include "ragdoll/contact_list.h"  // ContactList
#include "ragdoll/error.h"         // Error
#include "torsion_bounds.h"        // hold_backbone, hold_staggered

namespace ragdoll {
namespace {

constexpr int nitrogen = 7;  // atomic number

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Two atoms nearer than this are at one place. nm
constexpr double one_place = 1e-3;

/// Volumes that keep their sign keep at least this share of their input value.
constexpr double kept_share = 0.5;

/// A torsion in a small ring is kept when its volume is at least this share of the product of its
/// bond lengths: about 15 degrees.
constexpr double puckered_volume = 0.2;

/// A centre counts as tetrahedral when its volume is at least this share of the product of its bond
/// lengths (0.77 for three neighbours of an ideal tetrahedron, 3.1 for four, 0 in a plane).
/// Coordinates may be poor, and even a flattened carbon has a configuration; a nitrogen with three
/// neighbours turns inside out by itself, so that only a clear pyramid is kept.
constexpr double tetrahedral_volume = 0.02;
constexpr double pyramidal_volume = 0.35;

/// Three points are in a line below this sine.
constexpr double least_sine = 0.2;

/// Of a biaryl that is turned by more than about 30 degrees.
constexpr double twisted_volume = 0.35;

class Builder {
 public:
  Builder(const Molecule& molecule, const FrameworkOptions& options, const Box* box)
      : molecule_(molecule),
        options_(options),
        box_(box),
        x_(molecule.positions()),
        units_(molecule) {}

  Framework build() {
    check_options();
    check_places();
    add_joints();
    add_bonds();
    add_angles();
    add_small_rings();
    add_planar_units();
    add_cumulenes();
    add_hindered_axes();
    add_centres();
    if (options_.constraints) add_constraints(*options_.constraints);
    if (options_.contacts) add_contacts();
    return Framework(std::move(parts_));
  }

 private:
  int atom_count() const { return int(molecule_.atoms().size()); }
  const Vec3& x(int atom) const { return x_[std::size_t(atom)]; }

  void check_options() const {
    if (!(options_.contact_scale > 0) || !(options_.contact_scale <= 1.5))
      throw Error("the contact scale must be above 0 and at most 1.5");
    if (!(options_.planarity_degree > 0) || !(options_.planarity_degree <= 90))
      throw Error("the planarity must be above 0 and at most 90 degrees");
    if (!(options_.heavy_allowance >= 0) || !(options_.hydrogen_allowance >= 0))
      throw Error("the allowances of hydrogen bonds must not be negative");
  }

  void check_places() const {
    std::vector<CellPair> pairs;
    const CellList cells(x_, one_place, box_);
    for (std::size_t cell = 0; cell < cells.cell_count(); ++cell)
      cells.find_candidates(cell, pairs);
    std::sort(pairs.begin(), pairs.end(), [](const CellPair& a, const CellPair& b) {
      return a.p != b.p ? a.p < b.p : a.q < b.q;
    });
    for (const CellPair& pair : pairs) {
      const Vec3 d = x(pair.q) - x(pair.p);
      if ((box_ ? box_->minimum_image(d) : d).norm() < one_place)
        throw Error(molecule_.name(pair.p) + " and " + molecule_.name(pair.q) +
                    " are at one place; remove one of them or mend the coordinates");
    }
  }

  void add_joints() {
    for (const Atom& atom : molecule_.atoms()) {
      parts_.masses.push_back(atom.mass);
      parts_.labels.push_back(atom.label);
    }
    barred_.resize(molecule_.atoms().size());
  }

  bool has_bar(int p, int q) const {
    const std::vector<int>& partners = barred_[std::size_t(std::min(p, q))];
    return std::find(partners.begin(), partners.end(), std::max(p, q)) != partners.end();
  }

  /// A bar at the pair's input distance, unless the pair has one.
  void add_bar(int p, int q, BarKind kind) {
    if (has_bar(p, q)) return;
    barred_[std::size_t(std::min(p, q))].push_back(std::max(p, q));
    parts_.bars.push_back({p, q, (x(q) - x(p)).norm(), kind});
  }

  void add_bonds() {
    for (const Bond& bond : molecule_.bonds()) add_bar(bond.a, bond.b, BarKind::bond);
  }

  void add_angles() {
    for (int centre = 0; centre < atom_count(); ++centre) {
      const auto& around = molecule_.neighbours(centre);
      for (std::size_t i = 0; i < around.size(); ++i)
        for (std::size_t j = i + 1; j < around.size(); ++j)
          add_bar(around[i].atom, around[j].atom, BarKind::angle);
    }
  }

  /// In rings of four and five atoms the bars leave two shapes, mirror images of each other, of
  /// which a resolver could be caught in the wrong one: their torsions keep their signs.
  void add_small_rings() {
    for (const auto& [b, c, order] : molecule_.bonds())
      for (const auto& [a, bond_a] : molecule_.neighbours(b))
        for (const auto& [d, bond_d] : molecule_.neighbours(c))
          if (a != c && d != b && a != d && has_bar(a, d)) add_pucker(a, b, c, d);
  }

  void add_pucker(int a, int b, int c, int d) {
    const double volume = signed_volume(x(a), x(b), x(c), x(d));
    const double product = (x(b) - x(a)).norm() * (x(c) - x(b)).norm() * (x(d) - x(c)).norm();
    if (std::abs(volume) < puckered_volume * product) return;
    parts_.volumes.push_back(one_sided(a, b, c, d, volume, VolumeKind::planarity));
  }

  /// The volume keeps its sign and half its size.
  static Volume one_sided(int a, int b, int c, int d, double volume, VolumeKind kind) {
    const double kept = kept_share * volume;
    return {
        a,   b, c, d, volume > 0 ? kept : -infinity, volume > 0 ? infinity : kept, std::abs(volume),
        kind};
  }

  /// Bars across planar bonds, and volumes that hold their torsions.
  void add_planar_units() {
    for (std::size_t k = 0; k < molecule_.bonds().size(); ++k) {
      if (!units_.planar_bond(int(k))) continue;
      const auto [b, c, order] = molecule_.bonds()[k];
      for (const auto& [a, bond_a] : molecule_.neighbours(b))
        for (const auto& [d, bond_d] : molecule_.neighbours(c))
          if (a != c && d != b && a != d) add_bar(a, d, BarKind::planar);
      for (const int a : torsion_ends(b, c))
        for (const int d : torsion_ends(c, b))
          if (a != d) add_torsion_volume(a, b, c, d);
    }
  }

  /// Neighbours of `atom` other than `other` whose torsion is held: those that carry more of the
  /// molecule, or one where none does.
  std::vector<int> torsion_ends(int atom, int other) const {
    std::vector<int> inner, outer;
    for (const auto& [neighbour, bond] : molecule_.neighbours(atom)) {
      if (neighbour == other) continue;
      (molecule_.neighbours(neighbour).size() > 1 ? inner : outer).push_back(neighbour);
    }
    if (inner.empty() && !outer.empty()) inner.push_back(outer.front());
    return inner;
  }

  /// The volume of abcd is K sin(torsion), K = |ab x bc| |bc x cd| / |bc|: bounds on the torsion.
  void add_torsion_volume(int a, int b, int c, int d) {
    const Vec3 ab = x(b) - x(a), bc = x(c) - x(b), cd = x(d) - x(c);
    const Vec3 m = ab.cross(bc), n = bc.cross(cd);
    const double k = m.norm() * n.norm() / bc.norm();
    // collinear units have no torsion
    if (k < 0.1 * ab.norm() * bc.norm() * cd.norm()) return;
    const double torsion = std::atan2(bc.norm() * ab.dot(n), m.dot(n));
    const auto [lower, upper] = sine_range(torsion, planarity());
    parts_.volumes.push_back({a, b, c, d, k * lower, k * upper, k, VolumeKind::planarity});
  }

  /// Least and largest sine within `play` of an angle. rad
  static std::pair<double, double> sine_range(double angle, double play) {
    const double one = std::sin(angle - play), other = std::sin(angle + play);
    double lower = std::min(one, other), upper = std::max(one, other);
    // a quarter turn inside the range is an extreme of its own
    constexpr double quarter = std::numbers::pi / 2;
    if (std::abs(std::abs(angle) - quarter) < play)
      (angle > 0 ? upper : lower) = angle > 0 ? 1 : -1;
    return {lower, upper};
  }

  /// The ends of a chain of double bonds: across each other where their number is even (an allene,
  /// which has a hand), in one plane where it is odd (cis or trans).
  void add_cumulenes() {
    for (const Bond& bond : molecule_.bonds())
      for (const auto& [end, next] : {std::pair(bond.a, bond.b), std::pair(bond.b, bond.a)})
        if (units_.planar_atom(end) && units_.cumulated_atom(next)) add_cumulene(end, next);
  }

  void add_cumulene(int b, int next) {
    int before = b, c = next, doubles = 1;
    for (; units_.cumulated_atom(c); ++doubles) {
      const auto& around = molecule_.neighbours(c);
      const int beyond = around[around[0].atom == before ? 1 : 0].atom;
      before = std::exchange(c, beyond);
    }
    // each chain is met from both its ends
    if (c <= b || !units_.planar_atom(c)) return;
    const bool flat = doubles % 2 == 1;
    for (const int a : torsion_ends(b, next))
      for (const int d : torsion_ends(c, before)) {
        if (a == d) continue;
        if (flat) add_bar(a, d, BarKind::planar);
        if (flat)
          add_torsion_volume(a, b, c, d);
        else
          add_axis(a, b, c, d);
      }
  }

  /// A torsion near a quarter turn keeps its side.
  void add_axis(int a, int b, int c, int d) {
    const double volume = signed_volume(x(a), x(b), x(c), x(d));
    const double product = (x(b) - x(a)).norm() * (x(c) - x(b)).norm() * (x(d) - x(c)).norm();
    if (std::abs(volume) < tetrahedral_volume * product) return;
    parts_.volumes.push_back(one_sided(a, b, c, d, volume, VolumeKind::chirality));
  }

  /// Biaryls that do not turn over keep their hand; those that are flat at the start have none.
  void add_hindered_axes() {
    for (std::size_t k = 0; k < molecule_.bonds().size(); ++k) {
      const auto axis = hindered_axis(molecule_, int(k));
      if (!axis) continue;
      const auto [a, b, c, d] = *axis;
      const double volume = signed_volume(x(a), x(b), x(c), x(d));
      const double product = (x(b) - x(a)).norm() * (x(c) - x(b)).norm() * (x(d) - x(c)).norm();
      if (std::abs(volume) < twisted_volume * product) continue;
      parts_.volumes.push_back(one_sided(a, b, c, d, volume, VolumeKind::chirality));
    }
  }

  double planarity() const { return options_.planarity_degree * std::numbers::pi / 180; }

  /// Volumes of tetrahedral centres, and of planar atoms with three neighbours. Dative bonds do not
  /// count; a centre with five neighbours and more has one volume that tells its hand.
  void add_centres() {
    for (int centre = 0; centre < atom_count(); ++centre) {
      if (!units_.holds_shape(centre)) continue;
      const std::vector<int> around = bonded(centre);
      if (around.size() == 4) {
        add_chirality(around[0], around[1], around[2], around[3], centre);
      } else if (around.size() == 3) {
        if (units_.planar_atom(centre))
          add_improper(centre, around[0], around[1], around[2]);
        else
          add_chirality(centre, around[0], around[1], around[2], centre);
      } else if (around.size() > 4) {
        add_hand(centre, around);
      }
    }
  }

  /// Neighbours but for those of dative bonds.
  std::vector<int> bonded(int centre) const {
    std::vector<int> atoms;
    for (const auto& [atom, bond] : molecule_.neighbours(centre))
      if (molecule_.bonds()[std::size_t(bond)].order != BondOrder::dative) atoms.push_back(atom);
    return atoms;
  }

  /// The largest volume of the centre and three neighbours; bars hold the rest.
  void add_hand(int centre, const std::vector<int>& around) {
    double largest = 0;
    std::array<int, 3> chosen{};
    for (std::size_t i = 0; i < around.size(); ++i)
      for (std::size_t j = i + 1; j < around.size(); ++j)
        for (std::size_t k = j + 1; k < around.size(); ++k) {
          const double volume = signed_volume(x(centre), x(around[i]), x(around[j]), x(around[k]));
          // alike ones, as in an octahedron: the first, whatever the last bits are
          if (std::abs(volume) <= 1.001 * std::abs(largest)) continue;
          largest = volume;
          chosen = {around[i], around[j], around[k]};
        }
    if (std::abs(largest) < tetrahedral_volume * length_product(centre)) return;
    parts_.volumes.push_back(
        one_sided(centre, chosen[0], chosen[1], chosen[2], largest, VolumeKind::chirality));
  }

  void add_chirality(int a, int b, int c, int d, int centre) {
    const double volume = signed_volume(x(a), x(b), x(c), x(d));
    const bool turns = molecule_.atoms()[std::size_t(centre)].element == nitrogen &&
                       molecule_.neighbours(centre).size() == 3;
    const double least = turns ? pyramidal_volume : tetrahedral_volume;
    if (std::abs(volume) < least * length_product(centre)) return;
    parts_.volumes.push_back(one_sided(a, b, c, d, volume, VolumeKind::chirality));
  }

  /// Product of the three first bond lengths of a centre. nm^3
  double length_product(int centre) const {
    double product = 1;
    for (std::size_t k = 0; k < 3; ++k)
      product *= (x(molecule_.neighbours(centre)[k].atom) - x(centre)).norm();
    return product;
  }

  /// An elevation of one neighbour over the plane of the two others changes the volume by
  /// K sin(elevation), K = the lengths' product times the sine between the others, about 0.87.
  void add_improper(int centre, int p, int q, int r) {
    const double k = length_product(centre) * std::sin(2 * std::numbers::pi / 3);
    const double volume = signed_volume(x(centre), x(p), x(q), x(r));
    const double play = k * std::sin(planarity());
    parts_.volumes.push_back(
        {centre, p, q, r, volume - play, volume + play, k, VolumeKind::planarity});
  }

  // === Beside the covalent ones

  void add_constraints(const ConstraintOptions& constraints) {
    check_constraints(molecule_, constraints);
    if (constraints.metals)
      for (const auto& [metal, donor] : metal_bonds(molecule_, constraints.metal_slack))
        add_bar(metal, donor, BarKind::metal);
    for (const Bar& bar : constraints.coordination) add_bar(bar.p, bar.q, BarKind::metal);
    for (const Bar& bar : constraints.bars) add_user_bar(bar);
    if (!constraints.fixed.empty()) parts_.fixed.assign(molecule_.atoms().size(), 0);
    for (const int atom : constraints.fixed) parts_.fixed[std::size_t(atom)] = 1;
    BoundList bounds(barred_);
    const Conformations conformations(molecule_, constraints.conformations);
    add_noncovalent(molecule_, constraints, conformations, parts_, bounds);
    if (constraints.torsion_basins)
      hold_backbone(molecule_, units_, constraints.torsion_region, conformations, bounds);
    if (constraints.staggered)
      hold_staggered(molecule_, units_, constraints.eclipsed_degree, conformations, bounds);
    bounds.put_into(parts_);
    if (!constraints.fixed.empty()) drop_fixed_bounds();
  }

  /// Atoms that do not move, and those whose bars to such leave them no other place: to three of
  /// them that are not in a line, as a carbonyl's oxygen has them before a fixed residue.
  std::vector<std::uint8_t> placed_atoms() const {
    std::vector<std::uint8_t> placed = parts_.fixed;
    std::vector<std::vector<int>> around(placed.size());
    for (const Bar& bar : parts_.bars) {
      around[std::size_t(bar.p)].push_back(bar.q);
      around[std::size_t(bar.q)].push_back(bar.p);
    }
    std::vector<int> queue;
    for (int i = 0; i < atom_count(); ++i)
      if (placed[std::size_t(i)]) queue.push_back(i);
    for (std::size_t head = 0; head < queue.size(); ++head)
      for (const int other : around[std::size_t(queue[head])]) {
        if (placed[std::size_t(other)]) continue;
        std::vector<int> holders;
        for (const int holder : around[std::size_t(other)])
          if (placed[std::size_t(holder)]) holders.push_back(holder);
        if (!span_a_plane(holders)) continue;
        placed[std::size_t(other)] = 1;
        queue.push_back(other);
      }
    return placed;
  }

  bool span_a_plane(const std::vector<int>& atoms) const {
    if (atoms.size() < 3) return false;
    const Vec3 line = x(atoms[1]) - x(atoms[0]);
    return std::any_of(atoms.begin() + 2, atoms.end(), [&](int atom) {
      const Vec3 other = x(atom) - x(atoms[0]);
      return line.cross(other).norm() > least_sine * line.norm() * other.norm();
    });
  }

  /// Between atoms that cannot move a bound of ours can only stand in the way: the input may lie
  /// beyond it, or so near that the tolerance takes what is left. The user's own stay, so that what
  /// cannot be is told.
  void drop_fixed_bounds() {
    const std::vector<std::uint8_t> placed = placed_atoms();
    const auto is_fixed = [&placed](const auto& pair) {
      return placed[std::size_t(pair.p)] && placed[std::size_t(pair.q)];
    };
    std::erase_if(parts_.tethers, [&](const Tether& tether) {
      return tether.kind != TetherKind::user && is_fixed(tether);
    });
    std::erase_if(parts_.contacts, [&](const Contact& contact) {
      return contact.kind != ContactKind::user && is_fixed(contact);
    });
  }

  void add_user_bar(const Bar& bar) {
    if (!has_bar(bar.p, bar.q)) {
      add_bar(bar.p, bar.q, BarKind::user);
      if (bar.length > 0) parts_.bars.back().length = bar.length;
    } else if (bar.length > 0) {
      throw Error("there is a bar between " + molecule_.name(bar.p) + " and " +
                  molecule_.name(bar.q) +
                  " already; a bond or an angle has the length that it has");
    }
  }

  void add_contacts() {
    ContactRule& rule = parts_.contact_rule;
    rule.scale = options_.contact_scale;
    rule.heavy_allowance = options_.heavy_allowance;
    rule.hydrogen_allowance = options_.hydrogen_allowance;
    for (int i = 0; i < atom_count(); ++i) {
      rule.radii.push_back(van_der_waals_radius(molecule_.atoms()[std::size_t(i)].element));
      rule.polarity.push_back(polarity_of(molecule_, i));
    }
    add_exclusions(rule);
    // pairs that start closer than the rule allows keep their starting distance
    add_close_pairs(rule, x_);
    if (!options_.constraints || options_.constraints->conformations.empty()) return;
    for (const std::vector<Vec3>& positions : options_.constraints->conformations)
      add_close_pairs(rule, positions);
    // of one pair in several conformations the shortest distance
    std::sort(rule.close_pairs.begin(), rule.close_pairs.end(),
              [](const ClosePair& a, const ClosePair& b) {
                return std::tie(a.p, a.q, a.length) < std::tie(b.p, b.q, b.length);
              });
    const auto same = [](const ClosePair& a, const ClosePair& b) {
      return a.p == b.p && a.q == b.q;
    };
    rule.close_pairs.erase(std::unique(rule.close_pairs.begin(), rule.close_pairs.end(), same),
                           rule.close_pairs.end());
  }

  void add_close_pairs(ContactRule& rule, const std::vector<Vec3>& positions) const {
    ContactRule plain = rule;
    plain.close_pairs.clear();
    ContactList list(plain, 1e-9);
    list.update(positions, box_, 0);
    for (const NearPair& pair : list.pairs()) {
      const Vec3 d = positions[std::size_t(pair.q)] - positions[std::size_t(pair.p)];
      const double distance = (box_ ? box_->minimum_image(d) : d).norm();
      if (distance < pair.bound) rule.close_pairs.push_back({pair.p, pair.q, distance});
    }
  }

  /// Pairs up to three bonds apart, and those with a bar.
  void add_exclusions(ContactRule& rule) const {
    rule.exclusion_begin.push_back(0);
    std::vector<int> partners;
    for (int i = 0; i < atom_count(); ++i) {
      partners = barred_[std::size_t(i)];
      for (const auto& one : molecule_.neighbours(i)) {
        partners.push_back(one.atom);
        for (const auto& two : molecule_.neighbours(one.atom)) {
          partners.push_back(two.atom);
          for (const auto& three : molecule_.neighbours(two.atom)) partners.push_back(three.atom);
        }
      }
      std::sort(partners.begin(), partners.end());
      partners.erase(std::unique(partners.begin(), partners.end()), partners.end());
      for (const int q : partners)
        if (q > i) rule.exclusions.push_back(q);
      rule.exclusion_begin.push_back(int(rule.exclusions.size()));
    }
  }

  const Molecule& molecule_;
  const FrameworkOptions& options_;
  const Box* box_;
  const std::vector<Vec3>& x_;
  PlanarUnits units_;
  FrameworkParts parts_;
  std::vector<std::vector<int>> barred_;  ///< partners q > p that have a bar with p (natom)
};

}  // namespace

Framework build_framework(const Molecule& molecule, const FrameworkOptions& options,
                          const Box* box) {
  return Builder(molecule, options, box).build();
}

}  // namespace ragdoll
