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

}  // namespace

std::vector<TorsionTerm> torsion_terms(const RDKit::ROMol& mol, const TorsionTermOptions& options) {
  ForceFields::CrystalFF::CrystalFFDetails found;
  try {
    ForceFields::CrystalFF::getExperimentalTorsions(mol, found, true, options.small_rings,
                                                    options.macrocycles, false, table_version);
  } catch (const std::exception& error) {
    throw Error(std::string("RDKit finds no torsion preferences: ") + error.what());
  }
  std::vector<TorsionTerm> terms(found.expTorsionAtoms.size());
  for (std::size_t t = 0; t < terms.size(); ++t) {
    const auto& atoms = found.expTorsionAtoms[t];
    const auto& [signs, amplitudes] = found.expTorsionAngles[t];
    TorsionTerm& term = terms[t];
    term.a = atoms[0];
    term.b = atoms[1];
    term.c = atoms[2];
    term.d = atoms[3];
    for (std::size_t k = 0; k < term.sign.size(); ++k) {
      term.sign[k] = signs[k];
      term.amplitude[k] = amplitudes[k] * kilojoules;
    }
  }
  return terms;
}

}  // namespace ragdoll
