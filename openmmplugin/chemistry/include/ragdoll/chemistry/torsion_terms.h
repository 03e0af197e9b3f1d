// What the torsions of a molecule prefer, by RDKit's tables from crystal structures.

#pragma once
#include <vector>

#include "ragdoll/torsion_term.h"  // TorsionTerm

namespace RDKit {
class ROMol;
}

namespace ragdoll {

struct TorsionTermOptions {
  bool small_rings = false;  ///< also bonds in rings of up to eight atoms
  bool macrocycles = true;   ///< also bonds in rings of nine atoms and more
};

/// The terms that ETKDGv3 embeds with (tables of version 2): at most one a bond, in the tables'
/// order. Riniker and Landrum, J. Chem. Inf. Model. 55, 2562 (2015); Wang et al., ibid. 60, 2044
/// (2020). A macrocycle's bond to an atom that is also in a smaller ring has none, since versions
/// of the tables differ there: 2022.09 has none, 2026.09 has some for amides. All others are the
/// same. RDKit's numbers are taken for kcal/mol of 4.184 kJ/mol.
/// @param mol  sanitized, hydrogens explicit; atoms of terms are its indices
/// @throw Error  if ring information is missing and cannot be found
std::vector<TorsionTerm> torsion_terms(const RDKit::ROMol& mol,
                                       const TorsionTermOptions& options = {});

}  // namespace ragdoll
