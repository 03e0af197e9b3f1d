#include "ragdoll/chemistry/torsion_terms.h"

#include <GraphMol/ForceFieldHelpers/CrystalFF/TorsionPreferences.h>
#include <GraphMol/ROMol.h>

#include <cstddef>
#include <exception>

#include "ragdoll/error.h"  // Error

namespace ragdoll {
namespace {

constexpr double kilojoules = 4.184;       // per kcal
constexpr unsigned int table_version = 2;  // that of ETKDGv2 and v3

constexpr unsigned int macrocycle = 9;  // atoms in a ring, at least

/// A macrocycle's bond to an atom that is also in a smaller ring.
bool differs_by_version(const RDKit::ROMol& mol, unsigned int b, unsigned int c) {
  const RDKit::RingInfo& rings = *mol.getRingInfo();
  const RDKit::Bond* bond = mol.getBondBetweenAtoms(b, c);
  if (rings.minBondRingSize(bond->getIdx()) < macrocycle) return false;  // 0 out of rings
  return rings.minAtomRingSize(b) < macrocycle || rings.minAtomRingSize(c) < macrocycle;
}

}  // namespace

std::vector<TorsionTerm> torsion_terms(const RDKit::ROMol& mol, const TorsionTermOptions& options) {
  ForceFields::CrystalFF::CrystalFFDetails found;
  try {
    ForceFields::CrystalFF::getExperimentalTorsions(mol, found, true, options.small_rings,
                                                    options.macrocycles, false, table_version);
  } catch (const std::exception& error) {
    throw Error(std::string("RDKit finds no torsion preferences: ") + error.what());
  }
  std::vector<TorsionTerm> terms;
  for (std::size_t t = 0; t < found.expTorsionAtoms.size(); ++t) {
    const auto& atoms = found.expTorsionAtoms[t];
    const auto& [signs, amplitudes] = found.expTorsionAngles[t];
    if (differs_by_version(mol, unsigned(atoms[1]), unsigned(atoms[2]))) continue;
    TorsionTerm term{atoms[0], atoms[1], atoms[2], atoms[3], {}, {}};
    for (std::size_t k = 0; k < term.sign.size(); ++k) {
      term.sign[k] = signs[k];
      term.amplitude[k] = amplitudes[k] * kilojoules;
    }
    terms.push_back(term);
  }
  return terms;
}

}  // namespace ragdoll
