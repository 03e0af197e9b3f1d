#include "RagdollIntegratorProxy.h"

#include <openmm/OpenMMException.h>
#include <openmm/serialization/SerializationNode.h>

#include "FrameworkSerialization.h"     // writeFramework, readFramework
#include "ragdoll/RagdollIntegrator.h"  // RagdollIntegrator

using OpenMM::SerializationNode;

namespace ragdoll {

void RagdollIntegratorProxy::serialize(const void* object, SerializationNode& node) const {
  const auto& integrator = *reinterpret_cast<const RagdollIntegrator*>(object);
  node.setIntProperty("version", 1);
  node.setDoubleProperty("stepSize", integrator.getStepSize());
  node.setDoubleProperty("constraintTolerance", integrator.getConstraintTolerance());
  node.setIntProperty("integrationForceGroups", integrator.getIntegrationForceGroups());
  node.setStringProperty("order", integrator.getOrder());
  node.setStringProperty("weighting", integrator.getWeighting());
  node.setStringProperty("solver", integrator.getSolver());
  node.setIntProperty("maxIterations", integrator.getMaxIterations());
  node.setDoubleProperty("absoluteTolerance", integrator.getAbsoluteTolerance());
  node.setStringProperty("precision", integrator.getPrecision());
  node.setBoolProperty("useMassWeights", integrator.getUseMassWeights());
  node.setStringProperty("verletScope", integrator.getVerletScope());
  node.setBoolProperty("useSystemForces", integrator.getUseSystemForces());
  node.setStringProperty("perturbation", integrator.getPerturbation());
  node.setDoubleProperty("perturbationSize", integrator.getPerturbationSize());
  node.setIntProperty("randomSeed", integrator.getRandomNumberSeed());
  node.setBoolProperty("rejectUnresolved", integrator.getRejectUnresolved());
  writeFramework(integrator.getFramework(), node);
}

void* RagdollIntegratorProxy::deserialize(const SerializationNode& node) const {
  if (node.getIntProperty("version") != 1)
    throw OpenMM::OpenMMException("Unsupported version number of a RagdollIntegrator");
  auto integrator = std::make_unique<RagdollIntegrator>(node.getDoubleProperty("stepSize"));
  auto text = [&](const char* name, const std::string& byDefault) {
    return node.getStringProperty(name, byDefault);
  };
  integrator->setConstraintTolerance(
      node.getDoubleProperty("constraintTolerance", integrator->getConstraintTolerance()));
  integrator->setIntegrationForceGroups(
      node.getIntProperty("integrationForceGroups", integrator->getIntegrationForceGroups()));
  integrator->setOrder(text("order", integrator->getOrder()));
  integrator->setWeighting(text("weighting", integrator->getWeighting()));
  integrator->setSolver(text("solver", integrator->getSolver()));
  integrator->setMaxIterations(
      node.getIntProperty("maxIterations", integrator->getMaxIterations()));
  integrator->setAbsoluteTolerance(
      node.getDoubleProperty("absoluteTolerance", integrator->getAbsoluteTolerance()));
  integrator->setPrecision(text("precision", integrator->getPrecision()));
  integrator->setUseMassWeights(
      node.getBoolProperty("useMassWeights", integrator->getUseMassWeights()));
  integrator->setVerletScope(text("verletScope", integrator->getVerletScope()));
  integrator->setUseSystemForces(
      node.getBoolProperty("useSystemForces", integrator->getUseSystemForces()));
  integrator->setPerturbation(text("perturbation", integrator->getPerturbation()));
  integrator->setPerturbationSize(
      node.getDoubleProperty("perturbationSize", integrator->getPerturbationSize()));
  integrator->setRandomNumberSeed(
      node.getIntProperty("randomSeed", integrator->getRandomNumberSeed()));
  integrator->setRejectUnresolved(
      node.getBoolProperty("rejectUnresolved", integrator->getRejectUnresolved()));
  integrator->setFramework(readFramework(node));
  return integrator.release();
}

}  // namespace ragdoll
