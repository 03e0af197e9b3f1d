// Ring torsions: what tells shapes of a ring system apart, how they are liked, and which are the
// same by symmetry. Private to core.

#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "pliant_rings.h"          // PliantRings
#include "ragdoll/molecule.h"      // Molecule
#include "ragdoll/ring_systems.h"  // RingSystem
#include "ragdoll/torsion_term.h"  // TorsionTerm
#include "ragdoll/vec3.h"          // Vec3

namespace ragdoll {

/// The angle of rotation abcd, rad.
double torsion_of(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// E(phi) of a term, and its derivative. kJ/mol, kJ/mol/rad
struct TermValue {
  double energy = 0, slope = 0;
};
TermValue value_of(const TorsionTerm& term, double phi);

/// A term of atoms that are numbered from 0, such as those of a pool; its angle is that of abcd
/// plus a shift, where its own atoms are not among them.
struct ShiftedTerm {
  TorsionTerm term;
  double shift = 0;  ///< rad
};

class TorsionScore {
 public:
  explicit TorsionScore(std::vector<ShiftedTerm> terms);

  const std::vector<ShiftedTerm>& terms() const { return terms_; }

  /// kJ/mol
  double energy(std::span<const Vec3> positions) const;

  /// Displacements that bring each torsion towards a nearby value it likes, as far as its slope and
  /// its greatest curvature tell: what a step of Newton's would do for one alone. Weak terms yield
  /// to strong ones.
  void lead(std::span<const Vec3> positions, std::span<Vec3> displacements) const;

 private:
  std::vector<ShiftedTerm> terms_;
  std::vector<double> curvature_, share_;
};

/// Torsions whose four atoms are in a ring system, about bonds that turn, and the permutations of
/// them by which the system has its symmetry.
class RingTorsions {
 public:
  RingTorsions(const Molecule& molecule, const RingSystem& system, const PliantRings& pliant);

  /// By indices of system.atoms.
  const std::vector<std::array<int, 4>>& torsions() const { return torsions_; }
  int symmetries() const { return int(images_.size()); }

  /// rad, one for each torsion. @param positions  of system.atoms
  std::vector<float> measure(std::span<const Vec3> positions) const;

  /// Least root mean square difference over all symmetries, rad.
  double distance(std::span<const float> one, std::span<const float> other) const;

 private:
  void find_symmetries(const Molecule& molecule, const RingSystem& system);

  std::vector<std::array<int, 4>> torsions_;
  std::vector<std::vector<int>> images_;  ///< for each symmetry, of each torsion; the first is none
};

}  // namespace ragdoll
