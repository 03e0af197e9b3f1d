// Chemistry rules: what is planar, what keeps its shape, how large an atom is. Private to
// build_framework.

#pragma once
#include <optional>
#include <vector>

#include "ragdoll/contact_rule.h"  // Polarity
#include "ragdoll/molecule.h"      // Molecule

namespace ragdoll {

/// Which atoms are trigonal planar, and which bonds do not turn: double, aromatic, amide and
/// guanidinium (a single bond from N to a carbon that has a double bond to, or is aromatic with,
/// N, O or S). Boron with three bonds and carbocations are planar, too; what they bond to turns.
class PlanarUnits {
 public:
  explicit PlanarUnits(const Molecule& molecule);

  bool planar_atom(int atom) const { return planar_atom_[std::size_t(atom)]; }
  bool planar_bond(int bond) const { return planar_bond_[std::size_t(bond)]; }

  /// Between two double bonds: C=C=C goes straight through it, and its ends do not turn.
  bool cumulated_atom(int atom) const { return cumulated_atom_[std::size_t(atom)]; }

  /// Metals that are coordinated (dative bonds) are left to their bars; donors keep the shape that
  /// their own bonds have.
  bool holds_shape(int atom) const { return holds_shape_[std::size_t(atom)]; }

 private:
  std::vector<bool> planar_atom_, cumulated_atom_, holds_shape_;  ///< (natom)
  std::vector<bool> planar_bond_;                                 ///< (nbond)
};

/// A single bond between two aromatic rings that cannot pass each other, an axis of chirality: of
/// the four atoms beside it at least three carry more than hydrogen. Such biaryls take days and
/// more to turn over (LaPlante et al., J. Med. Chem. 54, 7005 (2011)).
struct HinderedAxis {
  int a = 0, b = 0, c = 0, d = 0;  ///< a torsion about it, between atoms that carry more
};
std::optional<HinderedAxis> hindered_axis(const Molecule& molecule, int bond);

/// Bondi's radii (1964), H by Rowland & Taylor (1996). nm; 0.17 where they have none
double van_der_waals_radius(int element);

bool is_metal(int element);

/// Single bonds' radii by Cordero et al. (2008), of metals and of what coordinates them. nm
double covalent_radius(int element);

/// N, O, F and S are polar; a hydrogen is where it is bonded to one of them.
Polarity polarity_of(const Molecule& molecule, int atom);

}  // namespace ragdoll
