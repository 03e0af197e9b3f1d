// The XML of FrameworkForce: its framework goes where the System goes.

#pragma once
#include <openmm/serialization/SerializationProxy.h>

namespace ragdoll {

class FrameworkForceProxy : public OpenMM::SerializationProxy {
 public:
  FrameworkForceProxy() : OpenMM::SerializationProxy("FrameworkForce") {}
  void serialize(const void* object, OpenMM::SerializationNode& node) const override;

  /// Parameters that the node does not name have their defaults.
  void* deserialize(const OpenMM::SerializationNode& node) const override;
};

}  // namespace ragdoll
