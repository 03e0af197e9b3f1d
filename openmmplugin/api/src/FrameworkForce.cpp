#include "ragdoll/FrameworkForce.h"

#include "FrameworkForceImpl.h"  // FrameworkForceImpl

namespace ragdoll {

FrameworkForce::FrameworkForce(std::shared_ptr<const Framework> initialFramework)
    : framework(std::move(initialFramework)) {
  setName("FrameworkForce");
}

void FrameworkForce::setFramework(std::shared_ptr<const Framework> newFramework) {
  framework = std::move(newFramework);
}

void FrameworkForce::setUsesPeriodicBoundaryConditions(bool isPeriodic) {
  periodic = isPeriodic;
}

OpenMM::ForceImpl* FrameworkForce::createImpl() const {
  return new FrameworkForceImpl(*this);
}

}  // namespace ragdoll
