#include "ragdoll/RagdollIntegrator.h"

#include <openmm/OpenMMException.h>
#include <openmm/System.h>
#include <openmm/internal/ContextImpl.h>

#include <algorithm>
#include <cmath>

#include "BinaryStream.h"            // writeValue, readValue
#include "TextArray.h"               // writeArray, readArray
#include "ragdoll/OpenMMErrors.h"    // withOpenMMErrors
#include "ragdoll/RagdollKernels.h"  // IntegrateRagdollStepKernel

using OpenMM::OpenMMException;
using OpenMM::SerializationNode;

namespace ragdoll {

RagdollIntegrator::RagdollIntegrator(double size) {
  setStepSize(size);
  setConstraintTolerance(settings.tolerance.value());
}

// ---- parameters

void RagdollIntegrator::setFramework(std::shared_ptr<const Framework> newFramework) {
  framework = std::move(newFramework);
  ++revision;
}

void RagdollIntegrator::setOrder(const std::string& order) {
  settings.order = withOpenMMErrors([&] { return order_kind(order); });
  ++revision;
}

std::string RagdollIntegrator::getOrder() const {
  return name_of(settings.order);
}

void RagdollIntegrator::setWeighting(const std::string& weighting) {
  settings.weighting = withOpenMMErrors([&] { return weighting_of(weighting); });
  ++revision;
}

std::string RagdollIntegrator::getWeighting() const {
  return name_of(settings.weighting);
}

void RagdollIntegrator::setSolver(const std::string& solver) {
  std::string known;
  for (const std::string& name : solver_names()) {
    if (name == solver) {
      settings.solver = solver;
      ++revision;
      return;
    }
    known += (known.empty() ? "" : ", ") + name;
  }
  throw OpenMMException("solver '" + solver + "' is not known; choose one of: " + known);
}

void RagdollIntegrator::setMaxIterations(int iterations) {
  if (iterations < 1)
    throw OpenMMException("The maximum of iterations has to be at least 1, not " +
                          std::to_string(iterations) + ".");
  settings.max_iterations = iterations;
  ++revision;
}

void RagdollIntegrator::setAbsoluteTolerance(double nanometers) {
  if (!(nanometers >= 0) || !std::isfinite(nanometers))
    throw OpenMMException("The absolute tolerance has to be 0 nm or more, not " +
                          std::to_string(nanometers) + " nm.");
  absoluteTolerance = nanometers;
  ++revision;
}

void RagdollIntegrator::setPrecision(const std::string& precision) {
  settings.precision = withOpenMMErrors([&] { return precision_of(precision); });
  ++revision;
}

std::string RagdollIntegrator::getPrecision() const {
  return name_of(settings.precision);
}

void RagdollIntegrator::setUseMassWeights(bool use) {
  settings.mass_weights = use;
  ++revision;
}

void RagdollIntegrator::setVerletScope(const std::string& scope) {
  verletScope = withOpenMMErrors([&] { return verlet_scope(scope); });
}

std::string RagdollIntegrator::getVerletScope() const {
  return name_of(verletScope);
}

void RagdollIntegrator::setUseSystemForces(bool use) {
  useSystemForces = use;
}

void RagdollIntegrator::setPerturbation(const std::string& kind) {
  perturbation = withOpenMMErrors([&] { return perturbation_kind(kind); });
}

std::string RagdollIntegrator::getPerturbation() const {
  return name_of(perturbation);
}

void RagdollIntegrator::setPerturbationSize(double nanometers) {
  if (!(nanometers >= 0) || !std::isfinite(nanometers))
    throw OpenMMException("The perturbation size has to be 0 nm or more, not " +
                          std::to_string(nanometers) + " nm.");
  perturbationSize = nanometers;
}

void RagdollIntegrator::setRandomNumberSeed(int newSeed) {
  seed = newSeed;
  ++revision;
}

void RagdollIntegrator::setRejectUnresolved(bool reject) {
  rejectUnresolved = reject;
}

ResolverSettings RagdollIntegrator::getResolverSettings() const {
  ResolverSettings current = settings;
  current.tolerance = absoluteTolerance > 0 ? Tolerance::nanometers(absoluteTolerance)
                                            : Tolerance(getConstraintTolerance());
  current.seed = std::uint64_t(seed);
  return current;
}

// ---- joint forces

void RagdollIntegrator::setJointForce(int joint, const OpenMM::Vec3& force) {
  const bool beyond = framework && joint >= framework->joint_count();
  if (joint < 0 || beyond)
    throw OpenMMException(
        "There is no joint " + std::to_string(joint) + " to put a force on" +
        (beyond ? "; the framework has " + std::to_string(framework->joint_count()) + " joints."
                : "."));
  if (std::size_t(joint) >= jointForces.size()) jointForces.resize(std::size_t(joint) + 1);
  jointForces[std::size_t(joint)] = force;
}

void RagdollIntegrator::setJointForces(const std::vector<OpenMM::Vec3>& forces) {
  if (framework && int(forces.size()) != framework->joint_count())
    throw OpenMMException("There are " + std::to_string(forces.size()) + " joint forces for the " +
                          std::to_string(framework->joint_count()) + " joints of the framework.");
  jointForces = forces;
}

void RagdollIntegrator::clearJointForces() {
  jointForces.clear();
}

std::vector<int> RagdollIntegrator::getRoots() const {
  std::vector<int> roots;
  if (useSystemForces || perturbation != PerturbationKind::none) return roots;
  for (std::size_t joint = 0; joint < jointForces.size(); ++joint)
    if (jointForces[joint] != OpenMM::Vec3()) roots.push_back(int(joint));
  return roots;
}

// ---- steps

void RagdollIntegrator::initialize(OpenMM::ContextImpl& contextRef) {
  if (owner != nullptr && &contextRef.getOwner() != owner)
    throw OpenMMException("This Integrator is already bound to a context");
  context = &contextRef;
  owner = &contextRef.getOwner();
  report = {};
  attemptedSteps = rejectedSteps = 0;
  positionsAreSet = false;
  kernel = context->getPlatform().createKernel(IntegrateRagdollStepKernel::Name(), contextRef);
  kernel.getAs<IntegrateRagdollStepKernel>().initialize(contextRef.getSystem(), *this);
}

void RagdollIntegrator::cleanup() {
  kernel = OpenMM::Kernel();
}

std::vector<std::string> RagdollIntegrator::getKernelNames() {
  return {IntegrateRagdollStepKernel::Name()};
}

void RagdollIntegrator::stateChanged(OpenMM::State::DataType changed) {
  if (changed == OpenMM::State::Positions) positionsAreSet = true;
}

double RagdollIntegrator::computeKineticEnergy() {
  return kernel.getAs<IntegrateRagdollStepKernel>().computeKineticEnergy(*context);
}

void RagdollIntegrator::step(int steps) {
  if (context == nullptr) throw OpenMMException("This Integrator is not bound to a context!");
  requireReady();
  for (int i = 0; i < steps; ++i) {
    context->updateContextState();
    if (useSystemForces) context->calcForcesAndEnergy(true, false, getIntegrationForceGroups());
    report = kernel.getAs<IntegrateRagdollStepKernel>().execute(*context, *this);
    ++attemptedSteps;
    if (!report.accepted) ++rejectedSteps;
    jointForces.clear();
  }
}

void RagdollIntegrator::requireReady() const {
  if (!positionsAreSet) throw OpenMMException("Particle positions have not been set");
  if (!framework)
    throw OpenMMException("RagdollIntegrator has no framework; call setFramework() before step().");
  const int particles = context->getSystem().getNumParticles();
  if (framework->joint_count() != particles)
    throw OpenMMException("The framework has " + std::to_string(framework->joint_count()) +
                          " joints, but the System has " + std::to_string(particles) +
                          " particles.");
  if (int(jointForces.size()) > particles)
    throw OpenMMException("There are forces on " + std::to_string(jointForces.size()) +
                          " joints, but the System has " + std::to_string(particles) +
                          " particles.");
  if (!(getStepSize() > 0) || !std::isfinite(getStepSize()))
    throw OpenMMException(
        "The step size has to be positive: velocities are displacements over it.");
}

// ---- checkpoints and saved states

void RagdollIntegrator::createCheckpoint(std::ostream& stream) const {
  writeValue(stream, jointForces.size());
  for (const OpenMM::Vec3& force : jointForces) writeValue(stream, force);
  report.writeTo(stream);
  writeValue(stream, attemptedSteps);
  writeValue(stream, rejectedSteps);
}

void RagdollIntegrator::loadCheckpoint(std::istream& stream) {
  jointForces.clear();
  for (auto left = readValue<std::size_t>(stream); left > 0; --left)
    jointForces.push_back(readValue<OpenMM::Vec3>(stream));
  report = StepReport::readFrom(stream);
  attemptedSteps = readValue<long long>(stream);
  rejectedSteps = readValue<long long>(stream);
}

void RagdollIntegrator::serializeParameters(SerializationNode& node) const {
  node.setIntProperty("version", 1);
  node.setLongProperty("attemptedSteps", attemptedSteps);
  node.setLongProperty("rejectedSteps", rejectedSteps);
  report.writeTo(node.createChildNode("Report"));
  writeArray(node, "JointForces", jointForces, [](TextWriter& text, const OpenMM::Vec3& force) {
    text.add(force[0]).add(force[1]).add(force[2]);
  });
}

void RagdollIntegrator::deserializeParameters(const SerializationNode& node) {
  if (node.getIntProperty("version") != 1)
    throw OpenMMException("Unsupported version number of RagdollIntegrator's parameters");
  attemptedSteps = node.getLongProperty("attemptedSteps");
  rejectedSteps = node.getLongProperty("rejectedSteps");
  report = StepReport::readFrom(node.getChildNode("Report"));
  jointForces = readArray<OpenMM::Vec3>(node, "JointForces", [](TextReader& text) {
    const double x = text.real(), y = text.real(), z = text.real();
    return OpenMM::Vec3(x, y, z);
  });
}

}  // namespace ragdoll
