#include <algorithm>  // find, max, min
#include <array>
#include <cmath>    // atan2, cos, remainder, sin
#include <limits>   // infinity
#include <numbers>  // pi
#include <optional>

#include <Eigen/Geometry>  // AngleAxisd

#include "ramachandran.h"
#include "torsion_bounds.h"

namespace ragdoll {
namespace {

constexpr int C = 6, N = 7, O = 8, H = 1;
constexpr double degree = std::numbers::pi / 180;
constexpr int phi_step = 8;  // degrees

double torsion_degree(const std::vector<Vec3>& x, int a, int b, int c, int d) {
  const Vec3 ab = x[std::size_t(b)] - x[std::size_t(a)], bc = x[std::size_t(c)] - x[std::size_t(b)],
             cd = x[std::size_t(d)] - x[std::size_t(c)];
  const Vec3 n = bc.cross(cd);
  return std::atan2(bc.norm() * ab.dot(n), ab.cross(bc).dot(n)) / degree;
}

/// Finds peptide bonds, and what is on both their sides.
class BackboneFinder {
 public:
  BackboneFinder(const Molecule& molecule, const PlanarUnits& units)
      : molecule_(molecule), units_(units) {}

  std::vector<BackboneResidue> find() const {
    std::vector<BackboneResidue> residues;
    for (int alpha = 0; alpha < int(molecule_.atoms().size()); ++alpha)
      if (const auto residue = around(alpha)) residues.push_back(*residue);
    return residues;
  }

 private:
  int element(int atom) const { return molecule_.atoms()[std::size_t(atom)].element; }
  bool is_tetrahedral_carbon(int atom) const {
    return element(atom) == C && !units_.planar_atom(atom) && heavy_neighbours(atom) > 0;
  }
  int heavy_neighbours(int atom) const {
    int count = 0;
    for (const auto& [other, bond] : molecule_.neighbours(atom)) count += element(other) != H;
    return count;
  }

  /// The oxygen of a carbonyl; -1: none.
  int oxygen_of(int carbon) const {
    if (element(carbon) != C || !units_.planar_atom(carbon)) return -1;
    for (const auto& [other, bond] : molecule_.neighbours(carbon))
      if (element(other) == O &&
          molecule_.bonds()[std::size_t(bond)].order == BondOrder::double_bond)
        return other;
    return -1;
  }

  /// The other end of a peptide bond; -1: none.
  int carbonyl_of(int nitrogen, int alpha) const {
    for (const auto& [other, bond] : molecule_.neighbours(nitrogen))
      if (other != alpha && oxygen_of(other) >= 0 && units_.planar_bond(bond)) return other;
    return -1;
  }
  int nitrogen_of(int carbon, int alpha) const {
    for (const auto& [other, bond] : molecule_.neighbours(carbon))
      if (other != alpha && element(other) == N && units_.planar_bond(bond)) return other;
    return -1;
  }

  /// The carbon beyond a peptide bond's end: an alpha carbon, or that of a cap.
  int alpha_of_carbonyl(int carbon, int nitrogen) const {
    for (const auto& [other, bond] : molecule_.neighbours(carbon))
      if (other != nitrogen && element(other) == C) return other;
    return -1;
  }
  int alpha_of_nitrogen(int nitrogen, int carbon) const {
    int any = -1;
    for (const auto& [other, bond] : molecule_.neighbours(nitrogen)) {
      if (other == carbon || element(other) != C) continue;
      any = other;
      // proline's N has two of them; the alpha carbon bears a carbonyl
      for (const auto& [next, further] : molecule_.neighbours(other))
        if (next != nitrogen && oxygen_of(next) >= 0) return other;
    }
    return any;
  }

  bool in_ring_of_five(int nitrogen, int alpha, int beta) const {
    for (const auto& [delta, bond] : molecule_.neighbours(nitrogen)) {
      if (delta == alpha || element(delta) != C) continue;
      for (const auto& [gamma, next] : molecule_.neighbours(delta))
        for (const auto& [back, last] : molecule_.neighbours(gamma))
          if (gamma != nitrogen && back == beta) return true;
    }
    return false;
  }

  std::optional<BackboneResidue> around(int alpha) const {
    if (!is_tetrahedral_carbon(alpha)) return std::nullopt;
    BackboneResidue r{};
    r.alpha = alpha;
    r.nitrogen = r.carbon = r.beta = -1;
    for (const auto& [other, bond] : molecule_.neighbours(alpha)) {
      if (element(other) == H) continue;
      if (r.nitrogen < 0 && element(other) == N && carbonyl_of(other, alpha) >= 0) {
        r.nitrogen = other;
      } else if (r.carbon < 0 && oxygen_of(other) >= 0 && nitrogen_of(other, alpha) >= 0) {
        r.carbon = other;
      } else if (r.beta < 0) {
        r.beta = other;
      } else {
        return std::nullopt;  // two side chains
      }
    }
    if (r.nitrogen < 0 || r.carbon < 0 || r.beta < 0) return std::nullopt;
    r.carbon_before = carbonyl_of(r.nitrogen, alpha);
    r.oxygen_before = oxygen_of(r.carbon_before);
    r.alpha_before = alpha_of_carbonyl(r.carbon_before, r.nitrogen);
    r.oxygen = oxygen_of(r.carbon);
    r.nitrogen_after = nitrogen_of(r.carbon, alpha);
    r.alpha_after = alpha_of_nitrogen(r.nitrogen_after, r.carbon);
    if (r.alpha_before < 0 || r.alpha_after < 0) return std::nullopt;
    r.is_proline = in_ring_of_five(r.nitrogen, alpha, r.beta);
    r.before_proline = heavy_neighbours(r.nitrogen_after) == 3;
    return r;
  }

  const Molecule& molecule_;
  const PlanarUnits& units_;
};

/// One residue, turned to any phi and psi.
class Turned {
 public:
  Turned(const BackboneResidue& residue, const std::vector<Vec3>& x) : r_(residue), x_(x) {
    phi_ = torsion_degree(x, r_.carbon_before, r_.nitrogen, r_.alpha, r_.carbon);
    psi_ = torsion_degree(x, r_.nitrogen, r_.alpha, r_.carbon, r_.nitrogen_after);
    // the side chain of L residues is a third of a turn behind the carbonyl, that of D ones before
    const double beta = torsion_degree(x, r_.carbon_before, r_.nitrogen, r_.alpha, r_.beta);
    is_mirrored_ = std::remainder(beta - phi_, 360) > 0;
    atoms_ = {r_.alpha_before, r_.carbon_before, r_.oxygen_before,  r_.nitrogen,
              r_.beta,         r_.oxygen,        r_.nitrogen_after, r_.alpha_after};
  }

  /// On the map of L residues. degrees
  double phi() const { return is_mirrored_ ? -phi_ : phi_; }
  double psi() const { return is_mirrored_ ? -psi_ : psi_; }

  const std::array<int, backbone_atom_count>& atoms() const { return atoms_; }

  /// Where the atoms are with these torsions, the side chain's own place kept.
  std::array<Vec3, backbone_atom_count> at(double phi, double psi) const {
    const double sign = is_mirrored_ ? -1 : 1;
    const auto turn = [&](int from, int to, double angle) {
      return Eigen::AngleAxisd(angle * degree, (x(to) - x(from)).normalized());
    };
    const Eigen::AngleAxisd before = turn(r_.nitrogen, r_.alpha, phi_ - sign * phi);
    const Eigen::AngleAxisd after = turn(r_.alpha, r_.carbon, sign * psi - psi_);
    std::array<Vec3, backbone_atom_count> places;
    for (std::size_t k = 0; k < places.size(); ++k) {
      places[k] = x(atoms_[k]);
      if (k < 3) places[k] = x(r_.nitrogen) + before * (places[k] - x(r_.nitrogen));
      if (k > 4) places[k] = x(r_.carbon) + after * (places[k] - x(r_.carbon));
    }
    return places;
  }

 private:
  const Vec3& x(int atom) const { return x_[std::size_t(atom)]; }

  const BackboneResidue& r_;
  const std::vector<Vec3>& x_;
  double phi_ = 0, psi_ = 0;
  bool is_mirrored_ = false;
  std::array<int, backbone_atom_count> atoms_ = {};
};

RamachandranMap map_of(const BackboneResidue& residue) {
  if (residue.is_proline) return RamachandranMap::proline;
  return residue.before_proline ? RamachandranMap::before_proline : RamachandranMap::general;
}

/// The part of the map that is nearest.
RamachandranPart nearest_part(RamachandranMap map, double phi, double psi) {
  RamachandranPart nearest = RamachandranPart::helix;
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < ramachandran_part_count; ++k)
    for (const RamachandranRow& row : rows_of(map, RamachandranPart(k))) {
      const double middle = (row.phi_from + row.phi_to) / 2.0;
      const double beyond = std::max(
          0.0, std::abs(std::remainder(phi - middle, 360)) - (row.phi_to - row.phi_from) / 2.0);
      const double up = std::remainder(psi - row.psi, 360);
      const double distance2 = beyond * beyond + up * up;
      if (distance2 >= least) continue;
      least = distance2;
      nearest = RamachandranPart(k);
    }
  return nearest;
}

class BackboneHolder {
 public:
  BackboneHolder(TorsionRegion region, const Conformations& conformations, BoundList& bounds)
      : region_(region), conformations_(conformations), bounds_(bounds) {}

  void hold(const BackboneResidue& residue) {
    const RamachandranMap map = map_of(residue);
    std::vector<RamachandranPart> parts;
    const auto add = [&](RamachandranPart part) {
      if (std::find(parts.begin(), parts.end(), part) == parts.end()) parts.push_back(part);
    };
    for (std::size_t k = 0; k < conformations_.count(); ++k) {
      const Turned start(residue, conformations_.at(k));
      add(nearest_part(map, start.phi(), start.psi()));
    }
    if (region_ == TorsionRegion::joined && parts.front() != RamachandranPart::left) {
      add(RamachandranPart::helix);
      add(RamachandranPart::strand);
    }
    distances_ = distances_for(parts);
    reach_.clear();
    // what the conformations have, then what the parts allow
    const Turned start(residue, conformations_.at(0));
    for (const BackboneDistance& d : distances_) {
      const int p = atom(start, d.p), q = atom(start, d.q);
      reach_.push_back(d.upper ? conformations_.longest(p, q) : conformations_.shortest(p, q));
    }
    for (const RamachandranPart part : parts) widen(start, rows_of(map, part));
    if (parts.size() > 1) widen(start, bridge_rows());
    for (std::size_t k = 0; k < distances_.size(); ++k) {
      const int p = atom(start, distances_[k].p), q = atom(start, distances_[k].q);
      if (distances_[k].upper)
        bounds_.tether(p, q, reach_[k], TetherKind::backbone);
      else
        bounds_.contact(p, q, reach_[k], ContactKind::backbone);
    }
  }

 private:
  static int atom(const Turned& residue, BackboneAtom name) {
    return residue.atoms()[std::size_t(name)];
  }

  void widen(const Turned& residue, std::span<const RamachandranRow> rows) {
    for (const RamachandranRow& row : rows)
      for (int phi = row.phi_from;; phi = std::min(phi + phi_step, row.phi_to)) {
        const auto places = residue.at(phi, row.psi);
        for (std::size_t k = 0; k < distances_.size(); ++k) {
          const BackboneDistance& d = distances_[k];
          const double length = (places[std::size_t(d.q)] - places[std::size_t(d.p)]).norm();
          reach_[k] = d.upper ? std::max(reach_[k], length) : std::min(reach_[k], length);
        }
        if (phi == row.phi_to) break;
      }
  }

  TorsionRegion region_;
  const Conformations& conformations_;
  BoundList& bounds_;
  std::vector<BackboneDistance> distances_;
  std::vector<double> reach_;  ///< nm
};

}  // namespace

std::vector<BackboneResidue> backbone_residues(const Molecule& molecule, const PlanarUnits& units) {
  return BackboneFinder(molecule, units).find();
}

void hold_backbone(const Molecule& molecule, const PlanarUnits& units, TorsionRegion region,
                   const Conformations& conformations, BoundList& bounds) {
  BackboneHolder holder(region, conformations, bounds);
  for (const BackboneResidue& residue : backbone_residues(molecule, units)) holder.hold(residue);
}

}  // namespace ragdoll
