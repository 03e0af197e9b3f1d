// From a molecule to its framework: what becomes a bar, a volume, a contact. Decided here, once,
// for every adaptor.

#pragma once
#include <optional>

#include "ragdoll/box.h"                 // Box
#include "ragdoll/constraint_options.h"  // ConstraintOptions
#include "ragdoll/framework.h"           // Framework
#include "ragdoll/molecule.h"            // Molecule

namespace ragdoll {

struct FrameworkOptions {
  bool contacts = true;
  double contact_scale = 0.85;       ///< of the sum of van der Waals radii
  double heavy_allowance = 0.01;     ///< nm; N, O, F, S pairs may be this much closer
  double hydrogen_allowance = 0.05;  ///< nm; a polar hydrogen and N, O, F, S
  double planarity_degree = 10;      ///< how far planar units may turn or bend from the input
  /// Hydrogen bonds, tethers, torsions and what the user sets; none: covalent bonds and contacts.
  std::optional<ConstraintOptions> constraints = {};
};

/// Bars from bonds (1-2), angles (1-3) and planar units (1-4 across double, aromatic, amide,
/// guanidinium bonds), all at their input lengths; volumes that keep tetrahedral centres and planar
/// units, and the hand of allenes; contacts from radii.
///
/// With `constraints` also what is held beside them. No bound is tighter than the input, but the
/// user's own: the input resolves as it is. Between residues, metals are held by bars to what
/// coordinates them, and by nothing else: bars between the donors around a metal would be more than
/// it has freedoms from three donors on, and freeze what really slides; contacts keep donors apart.
/// @param box  for contacts by minimum image: pairs that start closer than the rule through a face
/// of
///             the box keep that distance. Null: no periodic box
/// @throw Error if two atoms are at one place, or an option is out of range; it names the atoms
Framework build_framework(const Molecule& molecule, const FrameworkOptions& options = {},
                          const Box* box = nullptr);

}  // namespace ragdoll
