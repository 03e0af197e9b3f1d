#include "ReferenceRagdollKernels.h"

#include <openmm/reference/ReferenceVirtualSites.h>

#include "ragdoll/OpenMMErrors.h"     // withOpenMMErrors
#include "ragdoll/SystemFramework.h"  // frameworkOf
#include "ragdoll/break.h"            // verlet, perturb
#include "ragdoll/random.h"           // Random

namespace ragdoll {

namespace {

Vec3 toCore(const OpenMM::Vec3& v) {
  return {v[0], v[1], v[2]};
}

OpenMM::Vec3 toOpenMM(const Vec3& v) {
  return {v[0], v[1], v[2]};
}

OpenMM::ReferencePlatform::PlatformData& dataOf(OpenMM::ContextImpl& context) {
  return *static_cast<OpenMM::ReferencePlatform::PlatformData*>(context.getPlatformData());
}

StepReport reportOf(const ResolveReport& resolved) {
  StepReport report;
  report.iterations = resolved.iterations;
  report.barVisits = resolved.bar_visits;
  report.converged = resolved.converged;
  report.residual = resolved.residual;
  report.residualLength = resolved.residual_nm;
  report.stopReason = name_of(resolved.reason);
  report.worstConstraint = resolved.worst;
  return report;
}

}  // namespace

StepReport ReferenceIntegrateRagdollStepKernel::execute(OpenMM::ContextImpl& context,
                                                        const RagdollIntegrator& integrator) {
  return withOpenMMErrors([&] {
    Data& data = dataOf(context);
    const OpenMM::System& system = context.getSystem();
    refresh(system, integrator);
    predict(data, integrator);
    StepReport report = reportOf(resolve(data, system, integrator));

    // keep the step or take it back
    report.solver = resolver->solver();
    report.invertedCentres = inverted_centres(*framework, positions);
    const bool good = report.converged && report.invertedCentres == 0;
    report.accepted = good || !integrator.getRejectUnresolved();
    if (report.accepted) finish(data, system, integrator.getStepSize());
    data.time += integrator.getStepSize();
    ++data.stepCount;
    return report;
  });
}

// Derives framework and resolver anew if the integrator's parameters changed.
void ReferenceIntegrateRagdollStepKernel::refresh(const OpenMM::System& system,
                                                  const RagdollIntegrator& integrator) {
  if (revision == integrator.getRevision() && tolerance == integrator.getConstraintTolerance())
    return;
  framework = frameworkOf(*integrator.getFramework(), system);
  resolver = make_resolver(framework, integrator.getResolverSettings());
  revision = integrator.getRevision();
  tolerance = integrator.getConstraintTolerance();
}

void ReferenceIntegrateRagdollStepKernel::predict(const Data& data,
                                                  const RagdollIntegrator& integrator) {
  // where the joints are and where they come from
  const std::size_t count = data.positions->size();
  const double dt = integrator.getStepSize();
  positions.resize(count);
  previous.resize(count);
  for (std::size_t joint = 0; joint < count; ++joint) {
    positions[joint] = toCore((*data.positions)[joint]);
    previous[joint] = positions[joint] - toCore((*data.velocities)[joint]) * dt;
  }

  // forces of the System and of the user
  forces.assign(count, Vec3::Zero());
  if (integrator.getUseSystemForces())
    for (std::size_t joint = 0; joint < count; ++joint)
      forces[joint] = toCore((*data.forces)[joint]);
  const std::vector<OpenMM::Vec3>& jointForces = integrator.getJointForces();
  for (std::size_t joint = 0; joint < jointForces.size(); ++joint)
    forces[joint] += toCore(jointForces[joint]);

  // break
  verlet(positions, previous, forces, framework->masses(), framework->fixed(), dt,
         integrator.getVerletScopeKind());
  Random random(integrator.getResolverSettings().seed, RandomStream::perturbation,
                std::uint64_t(data.stepCount));
  perturb(positions, framework->fixed(), integrator.getPerturbationKind(),
          integrator.getPerturbationSize(), random);
}

ResolveReport ReferenceIntegrateRagdollStepKernel::resolve(const Data& data,
                                                           const OpenMM::System& system,
                                                           const RagdollIntegrator& integrator) {
  const OpenMM::Vec3* vectors = data.periodicBoxVectors;
  const Box box{toCore(vectors[0]), toCore(vectors[1]), toCore(vectors[2])};
  const std::vector<int> roots = integrator.getRoots();
  return resolver->resolve(positions,
                           {.roots = roots,
                            .step = std::uint64_t(data.stepCount),
                            .box = system.usesPeriodicBoundaryConditions() ? &box : nullptr});
}

void ReferenceIntegrateRagdollStepKernel::finish(Data& data, const OpenMM::System& system,
                                                 double stepSize) const {
  for (std::size_t joint = 0; joint < positions.size(); ++joint) {
    if (framework->masses()[joint] == 0) continue;
    const Vec3 displacement = positions[joint] - toCore((*data.positions)[joint]);
    (*data.velocities)[joint] = toOpenMM(displacement / stepSize);
    (*data.positions)[joint] = toOpenMM(positions[joint]);
  }
  data.virtualSites->computePositions(system, *data.positions, data.periodicBoxVectors);
}

double ReferenceIntegrateRagdollStepKernel::computeKineticEnergy(OpenMM::ContextImpl& context) {
  const Data& data = dataOf(context);
  double energy = 0;
  for (int particle = 0; particle < data.numParticles; ++particle) {
    const OpenMM::Vec3& velocity = (*data.velocities)[std::size_t(particle)];
    energy += 0.5 * context.getSystem().getParticleMass(particle) * velocity.dot(velocity);
  }
  return energy;
}

}  // namespace ragdoll
