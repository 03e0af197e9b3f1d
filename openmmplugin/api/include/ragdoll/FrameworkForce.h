// FrameworkForce: tells OpenMM which particles a framework holds together.

#pragma once
#include <openmm/Force.h>

#include <memory>

#include "ragdoll/framework.h"  // Framework

namespace ragdoll {

/// A Force without force or energy. Its framework's bars of kind `bond` count as bonds, so that
/// OpenMM sees molecules in a System that has no bonded force or constraint, and
/// `getState(enforcePeriodicBox=True)` moves each of them as a whole. It needs no kernel and works
/// on every platform, and with it the System's XML carries the framework.
class FrameworkForce : public OpenMM::Force {
 public:
  /// @param initialFramework  one joint for each particle of the System; it may be set later, but
  /// before a
  ///                   Context is created
  explicit FrameworkForce(std::shared_ptr<const Framework> initialFramework = nullptr);

  /// Contexts that exist already keep the molecules that they have, until they are reinitialized.
  void setFramework(std::shared_ptr<const Framework> newFramework);
  const std::shared_ptr<const Framework>& getFramework() const { return framework; }

  /// Whether this Force makes the System periodic, if no other does; false unless set. Simulation
  /// and its reporters wrap molecules into the box where the System is periodic, and
  /// RagdollIntegrator takes contacts by minimum image.
  void setUsesPeriodicBoundaryConditions(bool isPeriodic);
  bool usesPeriodicBoundaryConditions() const override { return periodic; }

 protected:
  OpenMM::ForceImpl* createImpl() const override;

 private:
  std::shared_ptr<const Framework> framework;
  bool periodic = false;
};

}  // namespace ragdoll
