#include <algorithm>  // find, min
#include <cmath>      // cos, sqrt
#include <numbers>    // pi
#include <vector>

#include "torsion_bounds.h"

namespace ragdoll {
namespace {

constexpr int H = 1, C = 6, N = 7, O = 8, P = 15, S = 16;

/// Bonds of rings up to this size are left to their bars.
constexpr int largest_small_ring = 7;

class StaggeredBonds {
 public:
  StaggeredBonds(const Molecule& molecule, const PlanarUnits& units)
      : molecule_(molecule), units_(units) {}

  bool is_staggered(const Bond& bond) const {
    return (bond.order == BondOrder::single || bond.order == BondOrder::unknown) &&
           is_tetrahedral(bond.a) && is_tetrahedral(bond.b) && !in_small_ring(bond);
  }

  std::vector<int> heavy_ends(int atom, int other) const {
    std::vector<int> ends;
    for (const auto& [end, bond] : molecule_.neighbours(atom))
      if (end != other && element(end) != H) ends.push_back(end);
    return ends;
  }

 private:
  int element(int atom) const { return molecule_.atoms()[std::size_t(atom)].element; }

  bool is_tetrahedral(int atom) const {
    const int e = element(atom);
    if (e == P || e == S) return true;
    if ((e != C && e != N && e != O) || units_.planar_atom(atom)) return false;
    for (const auto& [other, bond] : molecule_.neighbours(atom)) {
      const BondOrder order = molecule_.bonds()[std::size_t(bond)].order;
      if (order != BondOrder::single && order != BondOrder::unknown) return false;
    }
    // the bonds of an oxygen beside a flat atom lie in its plane
    if (e == O || e == N)
      for (const auto& [other, bond] : molecule_.neighbours(atom))
        if (units_.planar_atom(other)) return false;
    return true;
  }

  bool in_small_ring(const Bond& bond) const {
    std::vector<int> seen = {bond.a};
    std::size_t head = 0;
    for (int bonds = 1; bonds < largest_small_ring; ++bonds)
      for (const std::size_t end = seen.size(); head < end; ++head)
        for (const auto& [other, unused] : molecule_.neighbours(seen[head])) {
          if (other == bond.b && seen[head] != bond.a) return true;
          if (other != bond.b && std::find(seen.begin(), seen.end(), other) == seen.end())
            seen.push_back(other);
        }
    return false;
  }

  const Molecule& molecule_;
  const PlanarUnits& units_;
};

}  // namespace

void hold_staggered(const Molecule& molecule, const PlanarUnits& units, double eclipsed_degree,
                    const Conformations& conformations, BoundList& bounds) {
  const StaggeredBonds bonds(molecule, units);
  const double cosine = std::cos(eclipsed_degree * std::numbers::pi / 180);
  const auto x = [&](int atom) -> const Vec3& { return molecule.positions()[std::size_t(atom)]; };
  for (const Bond& bond : molecule.bonds()) {
    if (!bonds.is_staggered(bond)) continue;
    const Vec3 axis = (x(bond.b) - x(bond.a)).normalized();
    for (const int a : bonds.heavy_ends(bond.a, bond.b))
      for (const int d : bonds.heavy_ends(bond.b, bond.a)) {
        if (a == d) continue;
        // along the bond and away from it
        const Vec3 from_a = x(a) - x(bond.a), from_b = x(d) - x(bond.a);
        const double along_a = from_a.dot(axis), along_d = from_b.dot(axis);
        const double off_a = (from_a - along_a * axis).norm(),
                     off_d = (from_b - along_d * axis).norm();
        const double along = along_d - along_a;
        const double length =
            std::sqrt(along * along + off_a * off_a + off_d * off_d - 2 * off_a * off_d * cosine);
        bounds.contact(a, d, std::min(length, conformations.shortest(a, d)),
                       ContactKind::side_chain);
      }
  }
}

}  // namespace ragdoll
