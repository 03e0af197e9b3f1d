// Hydrogen bonds and salt bridges of a molecule, and their energies.

#pragma once
#include <vector>

#include "ragdoll/molecule.h"  // Molecule

namespace ragdoll {

inline constexpr double kilojoule_per_kilocalorie = 4.184;

struct HydrogenBond {
  int donor = 0, hydrogen = 0, acceptor = 0;  ///< atoms
  double energy = 0;                          ///< kJ/mol
  bool salt_bridge = false;
  double hydrogen_acceptor = 0;  ///< nm
  double donor_acceptor = 0;     ///< nm
  double angle_degree = 0;       ///< donor-hydrogen-acceptor
};

/// How far hydrogen and donor may be from the acceptor. nm
struct HydrogenBondReach {
  double hydrogen_acceptor, donor_acceptor;
};

struct HydrogenBondOptions {
  double weakest = -1.0 * kilojoule_per_kilocalorie;  ///< kJ/mol; weaker ones are left out
  HydrogenBondReach usual = {0.25, 0.35};
  HydrogenBondReach with_sulfur = {0.30, 0.40};
  HydrogenBondReach salt_bridge = {0.35, 0.45};
  double least_angle_degree = 110;      ///< donor-hydrogen-acceptor
  double least_base_angle_degree = 90;  ///< hydrogen-acceptor-base; not asked of salt bridges
};

/// All of them, strongest first.
///
/// Energies are those of Dahiyat, Gordon and Mayo (1997) in the variant of FIRST, with d the
/// distance of donor and acceptor: 8 kcal/mol [5 (2.8/d)^12 - 6 (2.8/d)^10] F, where F falls with
/// the angles by the hybridisation of both; a salt bridge, between groups of opposite charge, has
/// 10 kcal/mol [5 (3.2/(d + 0.375))^12 - 6 (3.2/(d + 0.375))^10] at any angle. Donors are N, O and
/// S; acceptors are O, S, and N with a lone pair.
/// @throw Error  an option that is not a number
std::vector<HydrogenBond> hydrogen_bonds(const Molecule& molecule,
                                         const HydrogenBondOptions& options = {});

}  // namespace ragdoll
