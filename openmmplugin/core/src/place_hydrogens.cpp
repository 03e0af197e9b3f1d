#include "ragdoll/place_hydrogens.h"

#include <algorithm>  // any_of, max, min
#include <array>
#include <cmath>    // acos, cos, exp, pow, sin
#include <numbers>  // pi
#include <utility>  // move, pair
#include <vector>

#include "aromatic_hydrogens.h"  // aromatic_hydrogen_sets
#include "chemistry_rules.h"     // PlanarUnits
#include "ragdoll/cell_list.h"   // CellList

namespace ragdoll {
namespace {

constexpr int H = 1, C = 6, N = 7, O = 8, S = 16;
constexpr double degree = std::numbers::pi / 180;

constexpr double hydrogen_mass = 1.008;

/// Bond lengths. nm
constexpr double length_to(int element) {
  return element == N ? 0.101 : element == O ? 0.096 : 0.134;
}

/// How far hydrogens that turn look for acceptors, from their donor. nm
constexpr double sight = 0.40;
constexpr int turns = 36;  // of a whole turn

class Placer {
 public:
  explicit Placer(const Molecule& molecule)
      : molecule_(molecule), units_(molecule), bare_(molecule.atoms().size()) {}

  Molecule place() {
    find_bare_parts();
    count_hydrogens();
    find_acceptors();
    for (int i = 0; i < atom_count(); ++i)
      if (missing_[std::size_t(i)] > 0) place_on(i, missing_[std::size_t(i)]);
    std::vector<Atom> atoms = molecule_.atoms();
    std::vector<Bond> bonds = molecule_.bonds();
    std::vector<Vec3> positions = molecule_.positions();
    for (const auto& [donor, place] : placed_) {
      bonds.push_back({donor, int(atoms.size()), BondOrder::single});
      atoms.push_back({H, 0, hydrogen_mass, "a hydrogen of " + molecule_.name(donor)});
      positions.push_back(place);
    }
    return Molecule(std::move(atoms), std::move(bonds), std::move(positions));
  }

 private:
  int atom_count() const { return int(molecule_.atoms().size()); }
  int element(int atom) const { return molecule_.atoms()[std::size_t(atom)].element; }
  const Vec3& at(int atom) const { return molecule_.positions()[std::size_t(atom)]; }
  bool is_polar(int atom) const {
    return element(atom) == N || element(atom) == O || element(atom) == S;
  }

  // === How many

  void find_bare_parts() {
    std::vector<bool> seen(molecule_.atoms().size());
    for (int start = 0; start < atom_count(); ++start) {
      if (seen[std::size_t(start)]) continue;
      std::vector<int> part = {start};
      seen[std::size_t(start)] = true;
      bool bare = true;
      for (std::size_t head = 0; head < part.size(); ++head)
        for (const auto& [other, bond] : molecule_.neighbours(part[head])) {
          bare = bare && !(is_polar(part[head]) && element(other) == H);
          if (seen[std::size_t(other)]) continue;
          seen[std::size_t(other)] = true;
          part.push_back(other);
        }
      for (const int atom : part) bare_[std::size_t(atom)] = bare && part.size() > 1;
    }
  }

  void count_hydrogens() {
    for (int i = 0; i < atom_count(); ++i)
      missing_.push_back(bare_[std::size_t(i)] && is_polar(i) ? missing_on(i) : 0);
    for (const auto& sets : aromatic_hydrogen_sets(molecule_)) {
      if (!bare_[std::size_t(sets.front().front())]) continue;
      if (sets.size() == 1)
        for (const int atom : sets.front()) ++missing_[std::size_t(atom)];
      else
        choices_.push_back(sets);
    }
  }

  /// What the valence leaves; of aromatic nitrogens only what their charge adds.
  int missing_on(int atom) const {
    const Atom& a = molecule_.atoms()[std::size_t(atom)];
    int bonds = 0, aromatic = 0;
    for (const auto& [other, bond] : molecule_.neighbours(atom)) {
      switch (molecule_.bonds()[std::size_t(bond)].order) {
        case BondOrder::unknown:
          return 0;
        case BondOrder::aromatic:
          ++aromatic;
          break;
        case BondOrder::double_bond:
          bonds += 2;
          break;
        case BondOrder::triple:
          bonds += 3;
          break;
        case BondOrder::single:
          ++bonds;
          break;
        default:
          break;
      }
    }
    if (aromatic > 0)
      return a.element == N && molecule_.neighbours(atom).size() == 2 && a.formal_charge > 0 ? 1
                                                                                             : 0;
    if (a.element == S && bonds > 2) return 0;
    const int valence = (a.element == N ? 3 : 2) + a.formal_charge;
    return std::max(0, valence - bonds);
  }

  // === Where

  void find_acceptors() {
    std::vector<int> atoms;
    std::vector<Vec3> positions;
    for (int i = 0; i < atom_count(); ++i) {
      if (!is_polar(i) || molecule_.neighbours(i).empty()) continue;
      atoms.push_back(i);
      positions.push_back(at(i));
    }
    acceptors_.resize(molecule_.atoms().size());
    if (atoms.empty()) return;
    std::vector<CellPair> pairs;
    const CellList cells(positions, sight, nullptr);
    for (std::size_t cell = 0; cell < cells.cell_count(); ++cell)
      cells.find_candidates(cell, pairs);
    for (const CellPair& pair : pairs) {
      const int p = atoms[std::size_t(pair.p)], q = atoms[std::size_t(pair.q)];
      if (missing_[std::size_t(p)] > 0 || has_choice(p))
        if (is_acceptor(q)) acceptors_[std::size_t(p)].push_back(q);
      if (missing_[std::size_t(q)] > 0 || has_choice(q))
        if (is_acceptor(p)) acceptors_[std::size_t(q)].push_back(p);
    }
    for (std::vector<int>& list : acceptors_) std::sort(list.begin(), list.end());
    choose();
  }

  bool has_choice(int atom) const {
    for (const auto& sets : choices_)
      for (const std::vector<int>& set : sets)
        if (std::find(set.begin(), set.end(), atom) != set.end()) return true;
    return false;
  }

  bool is_acceptor(int atom) const {
    const std::size_t bonds = molecule_.neighbours(atom).size();
    if (molecule_.atoms()[std::size_t(atom)].formal_charge > 0) return false;
    if (element(atom) != N) return bonds <= 2;
    return bonds == 2 && missing_[std::size_t(atom)] == 0 && units_.planar_atom(atom);
  }

  /// Of sets of aromatic nitrogens that could bear hydrogens, those that bond most strongly; the
  /// last of equals, which is the usual imidazole's.
  void choose() {
    for (const auto& sets : choices_) {
      const std::vector<int>* best = nullptr;
      double least = 0;
      for (const std::vector<int>& set : sets) {
        double energy = 0;
        for (const int atom : set) energy += strength(atom, opposite(atom));
        if (best && energy > least) continue;
        best = &set;
        least = energy;
      }
      for (const int atom : *best) ++missing_[std::size_t(atom)];
    }
  }

  /// Energy of a hydrogen's bonds, in units of the well's depth: distance and angle at the
  /// hydrogen.
  double strength(int donor, const Vec3& hydrogen) const {
    double energy = 0;
    for (const int acceptor : acceptors_[std::size_t(donor)]) {
      if (is_near(donor, acceptor)) continue;
      const Vec3 to_acceptor = at(acceptor) - hydrogen, to_donor = at(donor) - hydrogen;
      const double reach = to_acceptor.norm();
      if (reach > 0.30 || reach == 0) continue;
      const double cosine = to_acceptor.dot(to_donor) / (reach * to_donor.norm());
      if (cosine > 0) continue;
      const double theta = std::acos(std::max(-1.0, cosine));
      const double ratio2 = 0.28 * 0.28 / (at(acceptor) - at(donor)).squaredNorm();
      energy += (5 * std::pow(ratio2, 6) - 6 * std::pow(ratio2, 5)) * cosine * cosine *
                std::exp(-std::pow(std::numbers::pi - theta, 6));
    }
    return energy;
  }

  /// Bonded to it, or to one of its neighbours.
  bool is_near(int atom, int other) const {
    for (const auto& [neighbour, bond] : molecule_.neighbours(atom)) {
      if (neighbour == other) return true;
      for (const auto& [next, further] : molecule_.neighbours(neighbour))
        if (next == other) return true;
    }
    return false;
  }

  Vec3 along(int atom, const Vec3& direction) const {
    return at(atom) + length_to(element(atom)) * direction.normalized();
  }

  /// Away from all neighbours.
  Vec3 opposite(int atom) const {
    Vec3 sum = Vec3::Zero();
    for (const auto& [other, bond] : molecule_.neighbours(atom))
      sum -= (at(other) - at(atom)).normalized();
    return along(atom, sum);
  }

  bool is_flat(int atom) const {
    if (units_.planar_atom(atom)) return true;
    if (element(atom) != N) return false;
    // an aniline's
    for (const auto& [other, bond] : molecule_.neighbours(atom))
      if (units_.planar_atom(other)) return true;
    return false;
  }

  void place_on(int atom, int count) {
    const auto& around = molecule_.neighbours(atom);
    if (around.size() == 1)
      place_at_end(atom, around.front().atom, count);
    else if (around.size() == 2 && !is_flat(atom))
      place_in_chain(atom, count);
    else if (!around.empty())
      placed_.emplace_back(atom, opposite(atom));
  }

  /// Two places of a tetrahedral atom with two neighbours.
  void place_in_chain(int atom, int count) {
    const auto& around = molecule_.neighbours(atom);
    const Vec3 u = (at(around[0].atom) - at(atom)).normalized(),
               v = (at(around[1].atom) - at(atom)).normalized();
    const Vec3 back = -(u + v).normalized(), side = u.cross(v).normalized();
    const double half = 54.75 * degree;
    place_best(atom, count,
               {along(atom, std::cos(half) * back + std::sin(half) * side),
                along(atom, std::cos(half) * back - std::sin(half) * side)});
  }

  void place_best(int atom, int count, const std::array<Vec3, 2>& places) {
    if (count > 1) {
      for (const Vec3& place : places) placed_.emplace_back(atom, place);
    } else {
      const bool second = strength(atom, places[1]) < strength(atom, places[0]);
      placed_.emplace_back(atom, places[second]);
    }
  }

  void place_at_end(int atom, int neighbour, int count) {
    const Vec3 axis = (at(atom) - at(neighbour)).normalized();
    // off the axis, in the plane of one of the neighbour's other bonds
    Vec3 off = axis.unitOrthogonal();
    for (const auto& [other, bond] : molecule_.neighbours(neighbour)) {
      if (other == atom || element(other) == H) continue;
      const Vec3 bonded = at(other) - at(neighbour);
      const Vec3 across = bonded - bonded.dot(axis) * axis;
      if (across.norm() < 1e-3) continue;
      off = across.normalized();
      break;
    }
    if (element(atom) == N && is_flat(atom)) {
      const double cosine = 0.5, sine = std::sqrt(0.75);
      place_best(
          atom, count,
          {along(atom, cosine * axis + sine * off), along(atom, cosine * axis - sine * off)});
      return;
    }
    const Vec3 side = axis.cross(off);
    const auto place = [&](double angle) {
      const double tilt = 70.5 * degree;
      return along(atom, std::cos(tilt) * axis +
                             std::sin(tilt) * (std::cos(angle) * off + std::sin(angle) * side));
    };
    const auto angle_of = [&](int turn, int k) {
      return 2 * std::numbers::pi * (double(turn) / turns + k / 3.0);
    };
    count = std::min(count, 3);
    int best = turns / 2;  // trans, or staggered
    double least = 0;
    for (int turn = 0; turn < (count == 3 ? turns / 3 : turns); ++turn) {
      double energy = 0;
      for (int k = 0; k < count; ++k) energy += strength(atom, place(angle_of(turn, k)));
      if (energy >= least) continue;
      best = turn;
      least = energy;
    }
    for (int k = 0; k < count; ++k) placed_.emplace_back(atom, place(angle_of(best, k)));
  }

  const Molecule& molecule_;
  PlanarUnits units_;
  std::vector<bool> bare_;    ///< of parts without hydrogens on N, O, S (natom)
  std::vector<int> missing_;  ///< hydrogens (natom)
  std::vector<std::vector<std::vector<int>>> choices_;
  std::vector<std::vector<int>> acceptors_;   ///< near each donor (natom)
  std::vector<std::pair<int, Vec3>> placed_;  ///< donor and place
};

}  // namespace

Molecule place_hydrogens(const Molecule& molecule) {
  return Placer(molecule).place();
}

}  // namespace ragdoll
