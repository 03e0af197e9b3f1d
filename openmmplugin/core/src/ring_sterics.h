// Ring sterics: how atoms of a ring system, and those that hang on it, crowd each other. Private to
// core.

#pragma once
#include <span>
#include <vector>

#include "ragdoll/molecule.h"  // Molecule
#include "ragdoll/vec3.h"      // Vec3

namespace ragdoll {

/// Repulsion alone: Lennard-Jones' potential up to its minimum, raised to end there at 0, by the
/// radii and depths of the universal force field (Rappe et al., J. Am. Chem. Soc. 114, 10024,
/// 1992); half of it for atoms three bonds apart, nothing for nearer ones.
class RingSterics {
 public:
  /// @param atoms  that are looked at
  RingSterics(const Molecule& molecule, std::span<const int> atoms);

  /// kJ/mol. @param positions  of these atoms
  double energy(std::span<const Vec3> positions) const;

  /// Adds what brings crowded atoms apart: down the gradient, by so much. @param step  nm^2 mol/kJ
  void push(std::span<const Vec3> positions, double step, std::span<Vec3> displacements) const;

 private:
  struct Pair {
    int p, q;
    double square, depth;  ///< of the distance where it ends, nm^2; kJ/mol
  };
  std::vector<Pair> pairs_;
};

}  // namespace ragdoll
