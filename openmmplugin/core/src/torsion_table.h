// TorsionTable: how likely the turns about a bond are, and draws from them. Private to core.

#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "part_tree.h"             // PartTree
#include "ragdoll/molecule.h"      // Molecule
#include "ragdoll/random.h"        // Random
#include "ragdoll/torsion_term.h"  // TorsionTerm
#include "steric_rule.h"           // StericRule

namespace ragdoll {

/// Turns in steps of one degree from the start.
class TorsionTable {
 public:
  static constexpr int bins = 360;

  /// exp(-energy / temperature), without the bins that are not allowed; all of them, if none is.
  TorsionTable(std::span<const double, bins> energies, std::span<const bool, bins> allowed,
               double temperature);

  /// By the method of aliases (Walker 1977): one random number, whatever the weights.
  int draw(Random& random) const {
    const std::uint64_t word = random.next();
    const std::size_t bin = std::size_t((word >> 32) * bins >> 32);
    return std::uint32_t(word) < threshold_[bin] ? int(bin) : int(alias_[bin]);
  }

  double energy(int bin) const { return energy_[std::size_t(bin)]; }  ///< kJ/mol

 private:
  std::array<float, bins> energy_;
  std::array<std::uint32_t, bins> threshold_;
  std::array<std::uint16_t, bins> alias_;
};

/// A term where the molecule has none for a bond that turns: by the kinds of its two atoms.
TorsionTerm rule_for(const Molecule& molecule, const Part& part);

/// One for each part; that of a part which holds the frame is not used. Pairs of atoms whose
/// distance one bond alone decides are in the tables.
/// @param terms  preferences of the bonds that turn, others are left out
std::vector<TorsionTable> torsion_tables(const Molecule& molecule, const PartTree& tree,
                                         std::span<const TorsionTerm> terms,
                                         const StericRule& sterics, double temperature);

}  // namespace ragdoll
