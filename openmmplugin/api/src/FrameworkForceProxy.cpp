#include "FrameworkForceProxy.h"

#include <openmm/OpenMMException.h>
#include <openmm/serialization/SerializationNode.h>

#include "FrameworkSerialization.h"  // writeFramework, readFramework
#include "ragdoll/FrameworkForce.h"  // FrameworkForce

using OpenMM::SerializationNode;

namespace ragdoll {

void FrameworkForceProxy::serialize(const void* object, SerializationNode& node) const {
  const auto& force = *reinterpret_cast<const FrameworkForce*>(object);
  node.setIntProperty("version", 1);
  node.setIntProperty("forceGroup", force.getForceGroup());
  node.setStringProperty("name", force.getName());
  node.setBoolProperty("usesPeriodic", force.usesPeriodicBoundaryConditions());
  writeFramework(force.getFramework(), node);
}

void* FrameworkForceProxy::deserialize(const SerializationNode& node) const {
  if (node.getIntProperty("version") != 1)
    throw OpenMM::OpenMMException("Unsupported version number of a FrameworkForce");
  auto force = std::make_unique<FrameworkForce>(readFramework(node));
  force->setForceGroup(node.getIntProperty("forceGroup", force->getForceGroup()));
  force->setName(node.getStringProperty("name", force->getName()));
  force->setUsesPeriodicBoundaryConditions(node.getBoolProperty("usesPeriodic", false));
  return force.release();
}

}  // namespace ragdoll
