// One step on the Reference and CPU platforms.

#pragma once
#include <openmm/reference/ReferencePlatform.h>

#include <memory>
#include <vector>

#include "ragdoll/RagdollKernels.h"  // IntegrateRagdollStepKernel
#include "ragdoll/resolver.h"        // Resolver, ResolveReport
#include "ragdoll/vec3.h"            // Vec3

namespace ragdoll {

class ReferenceIntegrateRagdollStepKernel : public IntegrateRagdollStepKernel {
 public:
  using IntegrateRagdollStepKernel::IntegrateRagdollStepKernel;

  void initialize(const OpenMM::System&, const RagdollIntegrator&) override {}
  StepReport execute(OpenMM::ContextImpl& context, const RagdollIntegrator& integrator) override;
  double computeKineticEnergy(OpenMM::ContextImpl& context) override;

 private:
  using Data = OpenMM::ReferencePlatform::PlatformData;

  void refresh(const OpenMM::System& system, const RagdollIntegrator& integrator);
  void predict(const Data& data, const RagdollIntegrator& integrator);
  ResolveReport resolve(const Data& data, const OpenMM::System& system,
                        const RagdollIntegrator& integrator);
  void finish(Data& data, const OpenMM::System& system, double stepSize) const;

  int revision = -1;     ///< of the integrator's parameters that the members below were made from
  double tolerance = 0;  ///< likewise
  std::shared_ptr<const Framework> framework;  ///< with what the System adds
  std::unique_ptr<Resolver> resolver;
  std::vector<Vec3> positions;  ///< nm (njoint); where the joints go in this step
  std::vector<Vec3> previous;   ///< nm (njoint); one displacement before the start of the step
  std::vector<Vec3> forces;     ///< kJ/mol/nm (njoint)
};

}  // namespace ragdoll
