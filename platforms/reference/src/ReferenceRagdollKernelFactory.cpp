#include "ReferenceRagdollKernelFactory.h"

#include <openmm/OpenMMException.h>
#include <openmm/reference/ReferencePlatform.h>

#include "ReferenceRagdollKernels.h"  // ReferenceIntegrateRagdollStepKernel

namespace ragdoll {

OpenMM::KernelImpl* ReferenceRagdollKernelFactory::createKernelImpl(
    std::string name, const OpenMM::Platform& platform, OpenMM::ContextImpl&) const {
  if (name == IntegrateRagdollStepKernel::Name())
    return new ReferenceIntegrateRagdollStepKernel(name, platform);
  throw OpenMM::OpenMMException("Tried to create kernel with illegal kernel name '" + name + "'");
}

}  // namespace ragdoll

extern "C" void registerPlatforms() {}

/// Serves every platform whose state is the Reference platform's: Reference itself and CPU.
extern "C" void registerKernelFactories() {
  for (int i = 0; i < OpenMM::Platform::getNumPlatforms(); ++i) {
    OpenMM::Platform& platform = OpenMM::Platform::getPlatform(i);
    if (dynamic_cast<OpenMM::ReferencePlatform*>(&platform) == nullptr) continue;
    // the platform owns its factories
    platform.registerKernelFactory(ragdoll::IntegrateRagdollStepKernel::Name(),
                                   new ragdoll::ReferenceRagdollKernelFactory());
  }
}

/// For programs that link this library instead of loading it as a plugin.
extern "C" void registerRagdollReferenceKernelFactories() {
  registerKernelFactories();
}
