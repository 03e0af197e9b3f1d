// Molecule: atoms, bonds and starting positions, as an adaptor (RDKit, PDB) filled them in.

#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "ragdoll/vec3.h"  // Vec3

namespace ragdoll {

/// Bond orders as chemistry perceives them; the values are those of Python's Molecule.bond_orders.
enum class BondOrder : std::uint8_t {
  unknown = 0,
  single = 1,
  double_bond = 2,
  triple = 3,
  aromatic = 4,
  dative = 5,
};

struct Atom {
  int element = 0;         ///< atomic number
  int formal_charge = 0;   ///< elementary charges
  double mass = 0;         ///< dalton; 0 = does not move
  std::string label = {};  ///< for messages: "CA GLY45 A"
};

struct Bond {
  int a = 0, b = 0;  ///< atom indices
  BondOrder order = BondOrder::unknown;
};

/// Immutable after construction.
class Molecule {
 public:
  /// @throw Error  on an index out of range, a bond from an atom to itself, two bonds on one pair,
  ///               a coordinate that is not finite, sizes that disagree
  Molecule(std::vector<Atom> atoms, std::vector<Bond> bonds, std::vector<Vec3> positions);

  const std::vector<Atom>& atoms() const { return atoms_; }          ///< (natom)
  const std::vector<Bond>& bonds() const { return bonds_; }          ///< (nbond)
  const std::vector<Vec3>& positions() const { return positions_; }  ///< nm (natom)

  /// An atom's neighbours as (neighbour, bond), in the order of the bonds.
  struct Neighbour {
    int atom, bond;
  };
  const std::vector<Neighbour>& neighbours(int atom) const {
    return neighbours_[std::size_t(atom)];
  }

  /// The atom's label, or "atom 17" where it has none.
  std::string name(int atom) const;

 private:
  std::vector<Atom> atoms_;
  std::vector<Bond> bonds_;
  std::vector<Vec3> positions_;
  std::vector<std::vector<Neighbour>> neighbours_;
};

}  // namespace ragdoll
