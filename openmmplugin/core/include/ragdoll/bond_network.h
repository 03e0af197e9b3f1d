// Bond network: a molecule and its non-covalent bonds as bodies and bars.

#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "ragdoll/hydrogen_bonds.h"       // HydrogenBond
#include "ragdoll/hydrophobic_tethers.h"  // HydrophobicTether
#include "ragdoll/molecule.h"             // Molecule
#include "ragdoll/rigidity.h"             // BodyBarNetwork

namespace ragdoll {

/// Why a covalent bond does not turn.
enum class BondLock : std::uint8_t {
  none = 0,         ///< it turns
  peptide = 1,      ///< N to a carbonyl or the like, with a further heavy neighbour on N
  guanidinium = 2,  ///< other bonds of an N to a carbon that draws it flat: also amidines, anilines
  multiple = 3,     ///< double or triple, and both its atoms have other neighbours
  aromatic = 4,     ///< in an aromatic ring
  primary_amide = 5,  ///< an NH2 on a carbonyl; only its hydrogens turn
};
inline constexpr int bond_lock_count = 6;

/// One of each bond of a molecule. (nbond)
std::vector<BondLock> bond_locks(const Molecule& molecule);

struct BondNetworkOptions {
  /// By BondLock: whether such a bond has six bars. FIRST and its kin let the NH2 of amides turn.
  bool locks[bond_lock_count] = {false, true, true, true, true, false};
  int hydrogen_bond_bars = 5;  ///< between hydrogen and acceptor
  int tether_bars = 2;
};

/// Atoms are the bodies. Covalent bonds come first, in the molecule's order, then tethers, then
/// hydrogen bonds, both as given.
struct BondNetwork {
  BodyBarNetwork network;
  int covalent_bonds = 0, locked_bonds = 0, tethers = 0, hydrogen_bonds = 0;
};

/// @throw Error  an option out of range
BondNetwork build_bond_network(const Molecule& molecule, std::span<const HydrophobicTether> tethers,
                               std::span<const HydrogenBond> hydrogen_bonds,
                               const BondNetworkOptions& options = {});

}  // namespace ragdoll
