// The XML of RagdollIntegrator: all its parameters and its framework, not the state of a
// simulation.

#pragma once
#include <openmm/serialization/SerializationProxy.h>

namespace ragdoll {

class RagdollIntegratorProxy : public OpenMM::SerializationProxy {
 public:
  RagdollIntegratorProxy() : OpenMM::SerializationProxy("RagdollIntegrator") {}
  void serialize(const void* object, OpenMM::SerializationNode& node) const override;

  /// Parameters that the node does not name have their defaults.
  void* deserialize(const OpenMM::SerializationNode& node) const override;
};

}  // namespace ragdoll
