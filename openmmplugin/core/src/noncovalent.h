// Noncovalent: hydrogen bonds, hydrophobic tethers, stacked rings and the user's tethers and
// contacts as bounds of a framework. Private to build_framework.

#pragma once
#include <utility>  // pair
#include <vector>

#include "conformations.h"               // Conformations
#include "ragdoll/constraint_options.h"  // ConstraintOptions
#include "ragdoll/framework.h"           // FrameworkParts
#include "ragdoll/molecule.h"            // Molecule

namespace ragdoll {

/// Tethers and contacts of a framework that grows: at most one of each for a pair, and none where a
/// bar says all.
class BoundList {
 public:
  /// @param barred  partners q > p of each p that have a bar
  explicit BoundList(const std::vector<std::vector<int>>& barred) : barred_(barred) {}

  void tether(int p, int q, double length, TetherKind kind);
  void contact(int p, int q, double length, ContactKind kind);

  bool has_bar(int p, int q) const;

  /// Of two bounds on one pair the tighter holds, and its kind.
  void put_into(FrameworkParts& parts) const;

 private:
  const std::vector<std::vector<int>>& barred_;
  std::vector<Tether> tethers_;
  std::vector<Contact> contacts_;
};

/// All that ConstraintOptions asks for but bars, torsions and what is fixed. What one of the
/// conformations does not have is not held.
void add_noncovalent(const Molecule& molecule, const ConstraintOptions& options,
                     const Conformations& conformations, FrameworkParts& parts, BoundList& bounds);

/// Metals and the N, O and S that coordinate them, as pairs. Waters are left out: they come and go.
std::vector<std::pair<int, int>> metal_bonds(const Molecule& molecule, double slack);

/// An oxygen that is bonded to hydrogens alone, or to nothing.
bool is_water(const Molecule& molecule, int oxygen);

}  // namespace ragdoll
