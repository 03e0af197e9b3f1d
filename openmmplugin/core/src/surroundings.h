// Surroundings: which atoms of a molecule are alike. Private to core.

#pragma once
#include <cstdint>
#include <vector>

#include "ragdoll/molecule.h"  // Molecule

namespace ragdoll {

/// Numbers that are the same for atoms whose surroundings are, up to a dozen bonds away, by
/// elements, charges and bonds; hands and sides are not told apart. (natom)
std::vector<std::uint64_t> surroundings(const Molecule& molecule);

}  // namespace ragdoll
