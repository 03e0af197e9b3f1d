// Conformers: many conformers of a small molecule from one.

#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "ragdoll/molecule.h"      // Molecule
#include "ragdoll/torsion_term.h"  // TorsionTerm
#include "ragdoll/vec3.h"          // Vec3

namespace ragdoll {

struct ConformerSettings {
  int count = 50;  ///< conformers asked for
  std::uint64_t seed = 0;
  double prune_rmsd = 0;     ///< least RMSD of two conformers, heavy atoms, symmetry taken into
                             ///< account, nm; 0: those that are alike count too
  int candidates = 0;        ///< to choose from; 0: as the count wants
  double energy_window = 0;  ///< most torsion score above the least one, kJ/mol; 0: no bound
};

struct Conformers {
  std::vector<std::vector<Vec3>> positions;  ///< nm (nconformer, natom)
  std::vector<double> energies;              ///< torsion score, kJ/mol (nconformer)
  long candidates = 0;                       ///< without clashes, from which these were chosen
  long rejected = 0;                         ///< arrangements that clashed
  std::string reason;  ///< why there are fewer than asked, a sentence; empty otherwise
};

/// Conformers of the molecule that differ from its own positions by turns about bonds. Bond lengths
/// and angles, the hand of centres and the side of double bonds are those of the positions.
/// @param terms  preferences; bonds without one follow rules by the kinds of their atoms
/// @param keep_going  asked now and then; where it says no, what is there is returned, with a
/// reason
/// @throw Error  a count below 1, sizes that make no sense, a term of unknown atoms
Conformers sample_conformers(const Molecule& molecule, std::span<const TorsionTerm> terms,
                             const ConformerSettings& settings,
                             const std::function<bool()>& keep_going = {});

}  // namespace ragdoll
