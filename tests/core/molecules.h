// Molecules: named tiny ones with known answers. Lengths in nm.

#pragma once
#include "ragdoll/molecule.h"  // Molecule

namespace ragdoll::examples {

/// C, and H at the corners of a tetrahedron. Four elements make it chiral: methane_like(1, 9, 17,
/// 35).
Molecule methane_like(int h1 = 1, int h2 = 1, int h3 = 1, int h4 = 1);

/// Staggered: C 0, C 1, H 2-4 on C 0, H 5-7 on C 1.
Molecule ethane();

/// Pyramidal N 0 and three H.
Molecule ammonia();

/// Planar: C 0, O 1, N 2, H 3 on C, H 4 and H 5 on N.
Molecule formamide();

/// Trans: C 0, O 1, N 2, C 3 on C (its H 6-8), C 4 on N (its H 9-11), H 5 on N. The torsion 3-0-2-4
/// is 180 degrees, or `omega`.
Molecule methylacetamide(double omega_degree = 180);

/// C 0-5, H 6-11, in a plane.
Molecule benzene();

/// H 2 - C 0 # C 1 - H 3 on a line.
Molecule acetylene();

/// C 0 = C 1 = C 2 on a line, H 3 and H 4 on C 0, H 5 and H 6 on C 2 across.
Molecule allene();

/// An envelope of five carbons, C 0 out of the plane of the others.
Molecule cyclopentane_ring();

/// Seven carbons in a bent chain (C 0-6), then their hydrogens.
Molecule heptane();

/// Atoms of given elements at given places, without bonds.
Molecule loose_atoms(const std::vector<int>& elements, const std::vector<Vec3>& positions);

}  // namespace ragdoll::examples
