// Makes RagdollIntegrator's kernel for platforms that are ReferencePlatforms.

#pragma once
#include <openmm/KernelFactory.h>

#include <string>

namespace ragdoll {

class ReferenceRagdollKernelFactory : public OpenMM::KernelFactory {
 public:
  OpenMM::KernelImpl* createKernelImpl(std::string name, const OpenMM::Platform& platform,
                                       OpenMM::ContextImpl& context) const override;
};

}  // namespace ragdoll
