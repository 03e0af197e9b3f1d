// Peptide: heavy atoms of a chain of residues, made up, of any length. For sizes that no file has.

#pragma once
#include "ragdoll/molecule.h"  // Molecule

namespace benchmark {

struct Peptide {
  std::vector<ragdoll::Atom> atoms;
  std::vector<ragdoll::Bond> bonds;
  std::vector<ragdoll::Vec3> positions;  ///< nm
};

/// Helices and turns, side chains of ten kinds with ideal bonds, angles and planar groups; it may
/// cross itself. Whole residues: at least as many atoms as asked for. Linear time.
Peptide make_peptide(int atoms);

ragdoll::Molecule molecule_of(Peptide peptide);

}  // namespace benchmark
