// What is refused, and the sentences that say so.

#include <cmath>
#include <functional>

#include "platforms.h"

namespace ragdoll::test {

namespace {

std::string sentenceOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const OpenMM::OpenMMException& exception) {
    return exception.what();
  }
  return "nothing was thrown";
}

}  // namespace

class Refusals : public OnPlatform {};
ON_EVERY_PLATFORM(Refusals);

TEST(Setters, RefuseWrongValuesWithAnOpenMMException) {
  RagdollIntegrator integrator(0.001);
  EXPECT_THROW(RagdollIntegrator(-1), OpenMM::OpenMMException);
  EXPECT_THROW(integrator.setOrder("sideways"), OpenMM::OpenMMException);
  EXPECT_THROW(integrator.setWeighting("1/1"), OpenMM::OpenMMException);
  EXPECT_THROW(integrator.setSolver("magic"), OpenMM::OpenMMException);
  EXPECT_THROW(integrator.setMaxIterations(0), OpenMM::OpenMMException);
  EXPECT_THROW(integrator.setAbsoluteTolerance(-1e-3), OpenMM::OpenMMException);
  EXPECT_THROW(integrator.setAbsoluteTolerance(NAN), OpenMM::OpenMMException);
  EXPECT_THROW(integrator.setPrecision("quadruple"), OpenMM::OpenMMException);
  EXPECT_THROW(integrator.setVerletScope("some"), OpenMM::OpenMMException);
  EXPECT_THROW(integrator.setPerturbation("shake"), OpenMM::OpenMMException);
  EXPECT_THROW(integrator.setPerturbationSize(-0.1), OpenMM::OpenMMException);
  EXPECT_THROW(integrator.setPerturbationSize(NAN), OpenMM::OpenMMException);
  EXPECT_THROW(integrator.setConstraintTolerance(0), OpenMM::OpenMMException);
  EXPECT_THROW(integrator.setJointForce(-1, {}), OpenMM::OpenMMException);
  integrator.setFramework(chain(2));
  EXPECT_THROW(integrator.setJointForce(2, {}), OpenMM::OpenMMException);
  EXPECT_THROW(integrator.setJointForces(Positions(3)), OpenMM::OpenMMException);
  EXPECT_THROW(integrator.step(1), OpenMM::OpenMMException);
}

TEST_P(Refusals, AStepNeedsPositionsAFrameworkOfTheSystemsSizeAndAStepSize) {
  auto system = particles(3);
  RagdollIntegrator integrator(0.001);
  OpenMM::Context context(*system, integrator, *platform);
  const auto step = [&] { integrator.step(1); };
  EXPECT_EQ(sentenceOf(step), "Particle positions have not been set");
  context.setPositions(straight(3));
  EXPECT_EQ(sentenceOf(step),
            "RagdollIntegrator has no framework; call setFramework() before step().");
  integrator.setFramework(chain(2));
  EXPECT_EQ(sentenceOf(step), "The framework has 2 joints, but the System has 3 particles.");
  integrator.setFramework(chain(3));
  integrator.setStepSize(0);
  EXPECT_NE(sentenceOf(step).find("step size has to be positive"), std::string::npos);
  integrator.setStepSize(0.001);
  integrator.step(1);
  EXPECT_EQ(context.getStepCount(), 1);
}

TEST_P(Refusals, CoresErrorsArriveAsOpenMMExceptions) {
  auto system = particles(3);
  FrameworkParts cycle = chainParts(3);
  cycle.bars.push_back({0, 2, 0.15, BarKind::bond});
  RagdollIntegrator integrator(0.001);
  integrator.setFramework(std::make_shared<const Framework>(cycle));
  integrator.setOrder("bfs_tree");
  OpenMM::Context context(*system, integrator, *platform);
  context.setPositions(straight(3));
  EXPECT_THROW(integrator.step(1), OpenMM::OpenMMException);
}

TEST_P(Refusals, ABarToAVirtualSiteIsRefused) {
  auto system = particles(2);
  system->addParticle(0.0);
  system->setVirtualSite(2, new OpenMM::TwoParticleAverageSite(0, 1, 0.5, 0.5));
  RagdollIntegrator integrator(0.001);
  integrator.setFramework(chain(3));
  OpenMM::Context context(*system, integrator, *platform);
  context.setPositions(straight(3));
  EXPECT_EQ(sentenceOf([&] { integrator.step(1); }),
            "A bar is on particle 2, which is a virtual site and cannot be held.");
}

TEST_P(Refusals, AnIntegratorHasOneContextOnly) {
  auto system = particles(3);
  RagdollIntegrator integrator(0.001);
  OpenMM::Context context(*system, integrator, *platform);
  EXPECT_THROW(OpenMM::Context(*system, integrator, *platform), OpenMM::OpenMMException);
}

}  // namespace ragdoll::test
