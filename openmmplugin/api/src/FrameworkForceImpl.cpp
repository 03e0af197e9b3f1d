#include "FrameworkForceImpl.h"

#include <openmm/OpenMMException.h>
#include <openmm/System.h>
#include <openmm/internal/ContextImpl.h>

namespace ragdoll {

FrameworkForceImpl::FrameworkForceImpl(const FrameworkForce& force)
    : owner(force), framework(force.getFramework()) {
  forceGroup = force.getForceGroup();
}

void FrameworkForceImpl::initialize(OpenMM::ContextImpl& context) {
  if (!framework) throw OpenMM::OpenMMException("FrameworkForce has no framework.");
  const int particles = context.getSystem().getNumParticles();
  if (framework->joint_count() != particles)
    throw OpenMM::OpenMMException(
        "FrameworkForce's framework has " + std::to_string(framework->joint_count()) +
        " joints, but the System has " + std::to_string(particles) + " particles.");
}

std::vector<std::pair<int, int>> FrameworkForceImpl::getBondedParticles() const {
  std::vector<std::pair<int, int>> bonds;
  for (const Bar& bar : framework->bars())
    if (bar.kind == BarKind::bond) bonds.emplace_back(bar.p, bar.q);
  return bonds;
}

}  // namespace ragdoll
