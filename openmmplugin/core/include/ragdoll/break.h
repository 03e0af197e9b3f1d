// Break: what moves the joints before the constraints are resolved. Verlet under forces, or a
// perturbation.

#pragma once
#include <cstdint>
#include <span>
#include <string>

#include "ragdoll/random.h"  // Random
#include "ragdoll/vec3.h"    // Vec3

namespace ragdoll {

/// Which joints Verlet moves: those that a force acts on (MotionSim), or every joint with its
/// inferred velocity (Ragdoll physics).
enum class VerletScope { affected, all };

/// "affected" or "all". @throw Error
VerletScope verlet_scope(const std::string& name);
std::string name_of(VerletScope scope);

/// x_new = 2 x - x_old + F/m dt^2. Fixed and massless joints stay.
/// @param positions  x in, x_new out (njoint)
/// @param previous   x_old (njoint)
/// @param forces     kJ/mol/nm (njoint); a joint is affected where its force is not zero
/// @param masses     dalton (njoint)
void verlet(std::span<Vec3> positions, std::span<const Vec3> previous, std::span<const Vec3> forces,
            std::span<const double> masses, std::span<const std::uint8_t> fixed, double dt,
            VerletScope scope);

/// How random displacements are drawn.
enum class PerturbationKind {
  none,
  gaussian,  ///< each coordinate normal with deviation `size`
  ball,      ///< FRODA's: each joint uniform in a ball of radius `size`
};

/// "none", "gaussian" or "ball". @throw Error
PerturbationKind perturbation_kind(const std::string& name);
std::string name_of(PerturbationKind kind);

/// Moves every joint that is not fixed at random. @param size nm
void perturb(std::span<Vec3> positions, std::span<const std::uint8_t> fixed, PerturbationKind kind,
             double size, Random& random);

}  // namespace ragdoll
