// Registers the proxies when this library is loaded, once per process.

#include <openmm/serialization/SerializationProxy.h>

#include "FrameworkForceProxy.h"        // FrameworkForceProxy
#include "RagdollIntegratorProxy.h"     // RagdollIntegratorProxy
#include "ragdoll/FrameworkForce.h"     // FrameworkForce
#include "ragdoll/RagdollIntegrator.h"  // RagdollIntegrator

extern "C" __attribute__((constructor)) void registerRagdollSerializationProxies() {
  // OpenMM keeps the proxies for the life of the process
  OpenMM::SerializationProxy::registerProxy(typeid(ragdoll::RagdollIntegrator),
                                            new ragdoll::RagdollIntegratorProxy());
  OpenMM::SerializationProxy::registerProxy(typeid(ragdoll::FrameworkForce),
                                            new ragdoll::FrameworkForceProxy());
}
