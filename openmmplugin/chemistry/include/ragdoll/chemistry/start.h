// The one conformer that sampling starts from: the given one, or one that RDKit embeds.

#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace RDKit {
class ROMol;
class RWMol;
}  // namespace RDKit

namespace ragdoll {

struct StartOptions {
  std::uint64_t seed = 0;  ///< of the embedding
  bool embed = false;      ///< embed also where there are coordinates
};

struct Start {
  std::shared_ptr<RDKit::RWMol> mol;  ///< all hydrogens explicit; one conformer, its id 0
  std::vector<std::string> notes;     ///< how it was embedded, if not in the usual way
};

/// The molecule with all hydrogens, after its other atoms, one conformer in three dimensions, and
/// the configuration that this one has. Given coordinates are kept; hydrogens that they lack are
/// placed by RDKit. Otherwise RDKit embeds: ETKDGv3, then from random coordinates, then without its
/// knowledge of torsions. Wang et al., J. Chem. Inf. Model. 60, 2044 (2020).
/// @param mol  sanitized
/// @throw Error  if no start can be had; a clause that says why
Start make_start(const RDKit::ROMol& mol, const StartOptions& options = {});

}  // namespace ragdoll
