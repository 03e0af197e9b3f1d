// Ring conformers: the shapes that the rings of a molecule can take, found by break and resolve on
// the rings alone.

#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "ragdoll/build_framework.h"  // FrameworkOptions
#include "ragdoll/framework.h"        // Framework
#include "ragdoll/molecule.h"         // Molecule
#include "ragdoll/ring_systems.h"     // RingSystem
#include "ragdoll/torsion_term.h"     // TorsionTerm
#include "ragdoll/vec3.h"             // Vec3

namespace ragdoll {

struct RingSettings {
  int count = 20;  ///< most conformations of a ring system
  std::uint64_t seed = 0;
  double tolerance = 1e-4;       ///< relative, of bars and bounds
  double angle_play_degree = 3;  ///< how far angles in rings may be from the input
  double distinct_degree = 12;   ///< least RMS difference of ring torsions
  double energy_window = 45;     ///< most torsion score above the least one, kJ/mol
  bool fill = false;             ///< shapes between those that are liked, where `count` wants more;
                                 ///< contacts are less than half, and angles play half as
                                 ///< much again
  int attempts = 0;              ///< breaks of each ring system; 0: as its freedom wants
  /// Contacts and planarity; `constraints` are not looked at.
  FrameworkOptions framework = {.contact_scale = 0.75};
};

/// Conformations of a ring system. What hangs on it goes along with the atoms that are bonded to
/// the rings, which are part of each conformation.
struct RingPool {
  std::vector<int> atoms;  ///< of the rings, then all others that are bonded to one of them
  int ring_atoms = 0;      ///< how many of `atoms` are in rings
  /// Least torsion score first: those that torsions were led to. Behind them, where asked for, such
  /// as fill the gaps between, furthest from all others first.
  std::vector<std::vector<Vec3>> conformations;  ///< nm (n, natom)
  std::vector<double> energies;                  ///< torsion score, kJ/mol (n)
  int minima = 0;                                ///< how many were led to
};

/// One pool for each ring system that has more than one shape, in the order of ring_systems();
/// rigid ones have none. Bonds keep their lengths, angles at atoms of rings play by
/// `angle_play_degree` about the mean of those that are alike; stereocentres keep their hand,
/// planar bonds their side, contacts their bounds. Rings may pucker, and a nitrogen in a ring (but
/// of three) that has one more neighbour may turn inside out. The input's own shape counts as the
/// others do.
/// @param terms  preferences; bonds of rings without one like to be staggered
/// @throw Error  a count below 1, a tolerance or an angle that makes no sense, a term of unknown
///               atoms
std::vector<RingPool> ring_conformers(const Molecule& molecule, std::span<const TorsionTerm> terms,
                                      const RingSettings& settings = {});

/// The framework of a molecule whose rings may take other shapes: distances across angles at atoms
/// of rings are bounds instead of bars, and what keeps the pucker of small rings, or a ring's
/// nitrogen from turning inside out, is left out. Aromatic rings stay as they are.
Framework with_pliant_rings(const Framework& framework, const Molecule& molecule,
                            std::span<const RingSystem> systems, double angle_play_degree);

}  // namespace ragdoll
