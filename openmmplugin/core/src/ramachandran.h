// Ramachandran: the parts of the map of phi and psi that residues are found in, and the distances
// that hold them there. Private to build_framework.
//
// The parts are where a smoothed histogram of phi and psi in crystals (Lovell et al., Proteins 50,
// 437, 2003) has the densest nine tenths, and a little less: as psi, and the range of phi that goes
// with it. The distances were chosen, one after the other, to leave out most of what is outside a
// part: of the torsions that they allow, 91 % (helix), 96 % (strand) and 92 % (left-handed helix)
// are in the densest nine tenths of the map, and under 1 % outside its densest 99 %; joined, 68 %
// and 4 %.

#pragma once
#include <span>
#include <vector>

namespace ragdoll {

/// Torsions in degrees.
struct RamachandranRow {
  int psi, phi_from, phi_to;
};

enum class RamachandranPart { helix, strand, left };
inline constexpr int ramachandran_part_count = 3;

enum class RamachandranMap { general, proline, before_proline };

/// Empty where the map has no such part.
std::span<const RamachandranRow> rows_of(RamachandranMap map, RamachandranPart part);

/// Between helix and strand.
std::span<const RamachandranRow> bridge_rows();

/// Atoms of a residue and its two peptide units.
enum class BackboneAtom {
  alpha_before,
  carbon_before,
  oxygen_before,
  nitrogen,
  beta,
  oxygen,
  nitrogen_after,
  alpha_after,
};
inline constexpr int backbone_atom_count = 8;

struct BackboneDistance {
  BackboneAtom p, q;
  bool upper;  ///< at most, or at least
};

/// What holds a residue in parts of the map.
std::vector<BackboneDistance> distances_for(std::span<const RamachandranPart> parts);

}  // namespace ragdoll
