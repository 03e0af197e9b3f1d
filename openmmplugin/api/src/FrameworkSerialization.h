// A framework inside the XML of whatever holds it.

#pragma once
#include <openmm/serialization/SerializationNode.h>

#include <memory>

#include "ragdoll/framework.h"  // Framework

namespace ragdoll {

/// Adds a child node "Framework"; nothing if there is none.
void writeFramework(const std::shared_ptr<const Framework>& framework,
                    OpenMM::SerializationNode& parent);

/// The framework of the child node "Framework"; null if there is no such child.
/// @throw OpenMMException if what the node says is no framework
std::shared_ptr<const Framework> readFramework(const OpenMM::SerializationNode& parent);

}  // namespace ragdoll
