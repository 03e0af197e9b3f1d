#include "ragdoll/bond_network.h"

#include <string>  // to_string

#include "chemistry_rules.h"  // PlanarUnits
#include "ragdoll/error.h"    // Error

namespace ragdoll {
namespace {

constexpr int H = 1, C = 6, N = 7, O = 8, S = 16;

class Neighbourhood {
 public:
  explicit Neighbourhood(const Molecule& molecule) : molecule_(molecule) {}

  int element(int atom) const { return molecule_.atoms()[std::size_t(atom)].element; }

  int heavy_neighbours(int atom) const {
    int count = 0;
    for (const auto& [other, bond] : molecule_.neighbours(atom)) count += element(other) != H;
    return count;
  }

  int nitrogens(int atom) const {
    int count = 0;
    for (const auto& [other, bond] : molecule_.neighbours(atom)) count += element(other) == N;
    return count;
  }

  bool is_carbonyl(int atom) const {
    if (element(atom) != C) return false;
    for (const auto& [other, bond] : molecule_.neighbours(atom))
      if (molecule_.bonds()[std::size_t(bond)].order == BondOrder::double_bond &&
          (element(other) == O || element(other) == S))
        return true;
    return false;
  }

 private:
  const Molecule& molecule_;
};

}  // namespace

std::vector<BondLock> bond_locks(const Molecule& molecule) {
  const PlanarUnits planar(molecule);
  const Neighbourhood near(molecule);
  std::vector<BondLock> locks(molecule.bonds().size(), BondLock::none);
  for (std::size_t k = 0; k < locks.size(); ++k) {
    const auto [a, b, order] = molecule.bonds()[k];
    if (molecule.neighbours(a).size() < 2 || molecule.neighbours(b).size() < 2)
      continue;  // what is bonded once, such as the O of a carbonyl, has no torsion of its own
    const auto [c, n] = near.element(a) == N ? std::pair(b, a) : std::pair(a, b);
    if (order == BondOrder::aromatic) {
      locks[k] = BondLock::aromatic;
    } else if (order == BondOrder::double_bond || order == BondOrder::triple) {
      // one of the bonds of a guanidinium is written as a double one
      const bool shared = near.element(n) == N && near.nitrogens(c) > 1;
      locks[k] = shared ? BondLock::guanidinium : BondLock::multiple;
    } else if (planar.planar_bond(int(k))) {
      if (!near.is_carbonyl(c))
        locks[k] = BondLock::guanidinium;
      else if (near.heavy_neighbours(n) > 1)
        locks[k] = BondLock::peptide;
      else
        locks[k] = BondLock::primary_amide;
    }
  }
  return locks;
}

BondNetwork build_bond_network(const Molecule& molecule, std::span<const HydrophobicTether> tethers,
                               std::span<const HydrogenBond> hydrogen_bonds,
                               const BondNetworkOptions& options) {
  const auto check = [](int bars, const char* of) {
    if (bars < 1 || bars > rigid_bars)
      throw Error("the bars of " + std::string(of) + " are 1 to 6, not " + std::to_string(bars));
  };
  check(options.hydrogen_bond_bars, "a hydrogen bond");
  check(options.tether_bars, "a tether");

  BondNetwork result;
  result.network.bodies = int(molecule.atoms().size());
  result.covalent_bonds = int(molecule.bonds().size());
  result.tethers = int(tethers.size());
  result.hydrogen_bonds = int(hydrogen_bonds.size());
  std::vector<BodyBond>& bonds = result.network.bonds;
  const std::vector<BondLock> locks = bond_locks(molecule);
  for (std::size_t k = 0; k < locks.size(); ++k) {
    const bool locked = options.locks[std::size_t(locks[k])];
    result.locked_bonds += locked;
    bonds.push_back(
        {molecule.bonds()[k].a, molecule.bonds()[k].b, locked ? rigid_bars : hinge_bars});
  }
  for (const HydrophobicTether& tether : tethers)
    bonds.push_back({tether.a, tether.b, options.tether_bars});
  for (const HydrogenBond& bond : hydrogen_bonds)
    bonds.push_back({bond.hydrogen, bond.acceptor, options.hydrogen_bond_bars});
  return result;
}

}  // namespace ragdoll
