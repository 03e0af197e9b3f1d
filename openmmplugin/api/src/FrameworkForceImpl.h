// FrameworkForce in one Context.

#pragma once
#include <openmm/internal/ForceImpl.h>

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "ragdoll/FrameworkForce.h"  // FrameworkForce

namespace ragdoll {

class FrameworkForceImpl : public OpenMM::ForceImpl {
 public:
  explicit FrameworkForceImpl(const FrameworkForce& force);

  /// @throw OpenMMException without a framework of the System's size
  void initialize(OpenMM::ContextImpl& context) override;
  const FrameworkForce& getOwner() const override { return owner; }
  void updateContextState(OpenMM::ContextImpl&, bool&) override {}
  double calcForcesAndEnergy(OpenMM::ContextImpl&, bool, bool, int) override { return 0; }
  std::map<std::string, double> getDefaultParameters() override { return {}; }
  std::vector<std::string> getKernelNames() override { return {}; }
  std::vector<std::pair<int, int>> getBondedParticles() const override;

 private:
  const FrameworkForce& owner;
  std::shared_ptr<const Framework> framework;  ///< as it was when the Context was created
};

}  // namespace ragdoll
