#include "ragdoll/hydrogen_bonds.h"

#include <algorithm>  // clamp, max, sort
#include <cmath>      // acos, cos, exp, isfinite, pow
#include <numbers>    // pi
#include <optional>
#include <tuple>

#include "chemistry_rules.h"    // PlanarUnits
#include "ragdoll/cell_list.h"  // CellList
#include "ragdoll/error.h"      // Error

namespace ragdoll {
namespace {

constexpr int H = 1, C = 6, N = 7, O = 8, P = 15, S = 16;
constexpr double degree = std::numbers::pi / 180;

double square(double x) {
  return x * x;
}

/// Between 0 and pi.
double angle_between(const Vec3& u, const Vec3& v) {
  return std::acos(std::clamp(u.normalized().dot(v.normalized()), -1.0, 1.0));
}

/// Who may give and take hydrogen bonds, and how its orbitals lie.
class Partners {
 public:
  explicit Partners(const Molecule& molecule) : molecule_(molecule), planar_(molecule) {}

  bool is_donor(int atom) const {
    const int e = element(atom);
    return e == N || e == O || e == S;
  }

  bool is_acceptor(int atom) const {
    const std::size_t bonds = neighbours(atom).size();
    if (bonds == 0) return false;  // there is no base that it could be oriented by
    switch (element(atom)) {
      case O:
      case S:
        return bonds <= 2 && charge(atom) <= 0;
      case N:
        // a flat nitrogen with three bonds has given its pair away, as has one whose bonds are all
        // single
        if (!is_trigonal(atom)) return bonds <= 3 && charge(atom) <= 0;
        return bonds <= 2 && charge(atom) <= 0 && has_multiple_bond(atom) && !has_hydrogen(atom);
      default:
        return false;
    }
  }

  /// sp2 rather than sp3.
  bool is_trigonal(int atom) const {
    if (element(atom) != O) return planar_.planar_atom(atom);
    // both oxygens of a carboxylate, however its charge is written
    if (neighbours(atom).size() == 1) {
      const int other = neighbours(atom).front().atom;
      return (element(other) == C || element(other) == N) && planar_.planar_atom(other);
    }
    return planar_.planar_atom(atom);
  }

  /// A nitrogen whose group has a positive charge.
  bool is_positive(int atom) const {
    if (element(atom) != N) return false;
    if (charge(atom) > 0) return true;
    // the charge of an amidinium or an imidazolium is all its nitrogens'
    for (const auto& [carbon, single] : neighbours(atom)) {
      if (element(carbon) != C) continue;
      for (const auto& [other, bond] : neighbours(carbon)) {
        const BondOrder order = molecule_.bonds()[std::size_t(bond)].order;
        if (element(other) == N && charge(other) > 0 &&
            (order == BondOrder::double_bond || order == BondOrder::aromatic))
          return true;
      }
    }
    return false;
  }

  /// An oxygen of a carboxylate, a phosphate or the like.
  bool is_negative(int atom) const {
    if (element(atom) != O) return false;
    if (charge(atom) < 0) return true;
    if (neighbours(atom).size() != 1) return false;
    const int center = neighbours(atom).front().atom;
    if (element(center) != C && element(center) != P && element(center) != S) return false;
    for (const auto& [other, bond] : neighbours(center))
      if (element(other) == O && charge(other) < 0) return true;
    return false;
  }

  /// A normal of the plane through a donor, its hydrogen and its first other neighbour.
  std::optional<Vec3> donor_normal(int donor, int hydrogen) const {
    for (const auto& [other, bond] : neighbours(donor))
      if (other != hydrogen) return normal(donor, hydrogen, other);
    return std::nullopt;
  }

  /// A normal of the plane through an acceptor and its bases, or its base and that one's first
  /// other neighbour.
  std::optional<Vec3> acceptor_normal(int acceptor) const {
    const auto& bases = neighbours(acceptor);
    if (bases.size() > 1) return normal(acceptor, bases[0].atom, bases[1].atom);
    for (const auto& [other, bond] : neighbours(bases[0].atom))
      if (other != acceptor) return normal(bases[0].atom, acceptor, other);
    return std::nullopt;
  }

  const std::vector<Molecule::Neighbour>& neighbours(int atom) const {
    return molecule_.neighbours(atom);
  }
  int element(int atom) const { return molecule_.atoms()[std::size_t(atom)].element; }
  const Vec3& at(int atom) const { return molecule_.positions()[std::size_t(atom)]; }

 private:
  int charge(int atom) const { return molecule_.atoms()[std::size_t(atom)].formal_charge; }

  bool has_multiple_bond(int atom) const {
    for (const auto& [other, bond] : neighbours(atom)) {
      const BondOrder order = molecule_.bonds()[std::size_t(bond)].order;
      if (order == BondOrder::double_bond || order == BondOrder::aromatic) return true;
    }
    return false;
  }

  bool has_hydrogen(int atom) const {
    for (const auto& [other, bond] : neighbours(atom))
      if (element(other) == H) return true;
    return false;
  }

  std::optional<Vec3> normal(int center, int one, int two) const {
    const Vec3 n = (at(one) - at(center)).cross(at(two) - at(center));
    if (n.squaredNorm() == 0) return std::nullopt;
    return n;
  }

  const Molecule& molecule_;
  PlanarUnits planar_;
};

/// 12-10 well of the given depth and place. kJ/mol
double well(double kilocalories, double place, double distance) {
  const double ratio2 = square(place / distance);
  return kilocalories * kilojoule_per_kilocalorie *
         (5 * std::pow(ratio2, 6) - 6 * std::pow(ratio2, 5));
}

/// What angles leave of a hydrogen bond's energy; 0 where no base is at a fair angle.
double angular_factor(const Partners& partners, const HydrogenBond& bond, double theta,
                      double least_base_angle) {
  const bool donor_flat = partners.is_trigonal(bond.donor);
  const bool acceptor_flat = partners.is_trigonal(bond.acceptor);
  double gamma = 0;  // of the planes of two flat groups
  if (donor_flat && acceptor_flat) {
    const auto u = partners.donor_normal(bond.donor, bond.hydrogen);
    const auto v = partners.acceptor_normal(bond.acceptor);
    if (u && v) gamma = angle_between(*u, *v);
    if (u && v && gamma < std::numbers::pi / 2) gamma = std::numbers::pi - gamma;
  }
  const double along = square(std::cos(theta)) * std::exp(-std::pow(std::numbers::pi - theta, 6));
  double best = 0;
  for (const auto& [base, unused] : partners.neighbours(bond.acceptor)) {
    const double phi = angle_between(partners.at(bond.hydrogen) - partners.at(bond.acceptor),
                                     partners.at(base) - partners.at(bond.acceptor));
    if (phi < least_base_angle) continue;
    double factor = along;
    if (acceptor_flat)
      factor *= square(std::cos(std::max(phi, gamma)));
    else if (donor_flat)
      factor *= along;
    else
      factor *= square(std::cos(phi - 109.5 * degree));
    best = std::max(best, factor);
  }
  return best;
}

/// Fills in lengths, angle and energy. False where the geometry is not that of a bond
bool measure(const Partners& partners, const HydrogenBondOptions& options, HydrogenBond& bond) {
  const Vec3 &d = partners.at(bond.donor), &h = partners.at(bond.hydrogen),
             &a = partners.at(bond.acceptor);
  bond.salt_bridge = partners.is_positive(bond.donor) && partners.is_negative(bond.acceptor);
  const bool sulfur = partners.element(bond.donor) == S || partners.element(bond.acceptor) == S;
  const HydrogenBondReach& reach = bond.salt_bridge ? options.salt_bridge
                                   : sulfur         ? options.with_sulfur
                                                    : options.usual;
  bond.hydrogen_acceptor = (a - h).norm();
  bond.donor_acceptor = (a - d).norm();
  if (bond.hydrogen_acceptor > reach.hydrogen_acceptor ||
      bond.donor_acceptor > reach.donor_acceptor)
    return false;
  if (bond.hydrogen_acceptor == 0 || bond.donor_acceptor == 0 || (d - h).norm() == 0) return false;
  const double theta = angle_between(d - h, a - h);
  bond.angle_degree = theta / degree;
  if (bond.angle_degree < options.least_angle_degree) return false;
  if (bond.salt_bridge)
    bond.energy = well(10, 0.32, bond.donor_acceptor + 0.0375);
  else
    bond.energy = well(8, 0.28, bond.donor_acceptor) *
                  angular_factor(partners, bond, theta, options.least_base_angle_degree * degree);
  return bond.energy < 0 && bond.energy <= options.weakest;
}

void check(const HydrogenBondOptions& options) {
  for (const double value :
       {options.usual.hydrogen_acceptor, options.usual.donor_acceptor,
        options.with_sulfur.hydrogen_acceptor, options.with_sulfur.donor_acceptor,
        options.salt_bridge.hydrogen_acceptor, options.salt_bridge.donor_acceptor})
    if (!std::isfinite(value) || value <= 0)
      throw Error("the reach of hydrogen bonds is to be positive numbers");
  if (!std::isfinite(options.weakest) || !std::isfinite(options.least_angle_degree) ||
      !std::isfinite(options.least_base_angle_degree))
    throw Error("the weakest energy and the least angles of hydrogen bonds are to be numbers");
  if (options.weakest > 0)
    throw Error("the weakest energy of hydrogen bonds is not to be above zero");
}

}  // namespace

std::vector<HydrogenBond> hydrogen_bonds(const Molecule& molecule,
                                         const HydrogenBondOptions& options) {
  check(options);
  const Partners partners(molecule);

  // hydrogens of donors first, then acceptors
  std::vector<int> atoms, donors;
  for (int i = 0; i < int(molecule.atoms().size()); ++i) {
    if (partners.element(i) != H || molecule.neighbours(i).size() != 1) continue;
    const int donor = molecule.neighbours(i).front().atom;
    if (!partners.is_donor(donor)) continue;
    atoms.push_back(i);
    donors.push_back(donor);
  }
  for (int i = 0; i < int(molecule.atoms().size()); ++i)
    if (partners.is_acceptor(i)) atoms.push_back(i);
  std::vector<HydrogenBond> bonds;
  if (donors.empty()) return bonds;
  std::vector<Vec3> positions;
  for (const int atom : atoms) positions.push_back(molecule.positions()[std::size_t(atom)]);

  const double reach =
      std::max({options.usual.hydrogen_acceptor, options.with_sulfur.hydrogen_acceptor,
                options.salt_bridge.hydrogen_acceptor});
  // a cell list gives what is closer than its cutoff, and a few more
  std::vector<CellPair> pairs;
  const CellList cells(positions, reach * (1 + 1e-9), nullptr);
  for (std::size_t cell = 0; cell < cells.cell_count(); ++cell) cells.find_candidates(cell, pairs);
  const int hydrogens = int(donors.size());
  for (const CellPair& pair : pairs) {
    if (pair.p >= hydrogens || pair.q < hydrogens) continue;
    HydrogenBond bond;
    bond.donor = donors[std::size_t(pair.p)];
    bond.hydrogen = atoms[std::size_t(pair.p)];
    bond.acceptor = atoms[std::size_t(pair.q)];
    bool bonded = bond.acceptor == bond.donor;
    for (const auto& [other, k] : molecule.neighbours(bond.donor))
      bonded = bonded || other == bond.acceptor;
    if (!bonded && measure(partners, options, bond)) bonds.push_back(bond);
  }
  std::sort(bonds.begin(), bonds.end(), [](const HydrogenBond& a, const HydrogenBond& b) {
    return std::tuple(a.energy, a.hydrogen, a.acceptor) <
           std::tuple(b.energy, b.hydrogen, b.acceptor);
  });
  return bonds;
}

}  // namespace ragdoll
