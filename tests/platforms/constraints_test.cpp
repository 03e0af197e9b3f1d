// What the System adds: masses, particles that do not move, virtual sites, constraints.

#include "platforms.h"
#include "ragdoll/SystemFramework.h"  // frameworkOf

namespace ragdoll::test {

class Constraints : public OnPlatform {};
ON_EVERY_PLATFORM(Constraints);

TEST_P(Constraints, MasslessParticlesAndFixedJointsNeverMove) {
  auto system = particles(4);
  system->setParticleMass(0, 0.0);
  FrameworkParts parts = chainParts(4);
  parts.fixed = {0, 0, 0, 1};
  RagdollIntegrator integrator(0.002);
  integrator.setFramework(std::make_shared<const Framework>(parts));
  integrator.setVerletScope("all");
  integrator.setPerturbation("gaussian");
  OpenMM::Context context(*system, integrator, *platform);
  context.setPositions({{0, 0, 0}, {0.13, 0.05, 0}, {0.27, 0.05, 0}, {0.4, 0, 0}});
  context.setVelocities({{9, 9, 9}, {0, 0, 0}, {0, 0, 0}, {9, 9, 9}});
  integrator.setJointForce(0, {1e5, 0, 0});
  integrator.step(20);
  EXPECT_EQ(positionsOf(context)[0], OpenMM::Vec3(0, 0, 0));
  EXPECT_EQ(positionsOf(context)[3], OpenMM::Vec3(0.4, 0, 0));
  EXPECT_NE(positionsOf(context)[1], OpenMM::Vec3(0.13, 0.05, 0));
}

TEST_P(Constraints, AVirtualSiteFollowsItsParticles) {
  auto system = particles(2);
  system->addParticle(0.0);
  system->setVirtualSite(2, new OpenMM::TwoParticleAverageSite(0, 1, 0.5, 0.5));
  FrameworkParts parts = chainParts(2);
  parts.masses.push_back(0.0);
  RagdollIntegrator integrator(0.002);
  integrator.setFramework(std::make_shared<const Framework>(parts));
  OpenMM::Context context(*system, integrator, *platform);
  context.setPositions({{0, 0, 0}, {0.15, 0, 0}, {0.075, 0, 0}});
  integrator.setJointForce(1, {0, 1e5, 0});
  integrator.step(1);
  const Positions moved = positionsOf(context);
  EXPECT_GT(moved[2][1], 0.001);
  EXPECT_NEAR(distance(moved[2], (moved[0] + moved[1]) * 0.5), 0, 1e-12);
}

TEST_P(Constraints, ConstraintsOfTheSystemAreBarsAndTheirDistancesHold) {
  auto system = particles(3);
  system->addConstraint(2, 1, 0.12);  // the framework has this bar with 0.15 nm
  system->addConstraint(0, 2, 0.2);
  RagdollIntegrator integrator(0.002);
  integrator.setFramework(chain(3));
  integrator.setConstraintTolerance(1e-8);
  OpenMM::Context context(*system, integrator, *platform);
  context.setPositions({{0, 0, 0}, {0.15, 0, 0}, {0.15, 0.15, 0}});
  integrator.step(1);
  ASSERT_TRUE(integrator.getConverged());
  const Positions p = positionsOf(context);
  EXPECT_NEAR(distance(p[0], p[1]), 0.15, 1e-8);
  EXPECT_NEAR(distance(p[1], p[2]), 0.12, 1e-8);
  EXPECT_NEAR(distance(p[0], p[2]), 0.20, 1e-8);
}

TEST(SystemFramework, MassesAreTheSystemsAndTheFrameworkItselfStaysAsItWas) {
  OpenMM::System system;
  system.addParticle(1.0);
  system.addParticle(0.0);
  const auto framework = chain(2);
  const auto derived = frameworkOf(*framework, system);
  EXPECT_EQ(derived->masses(), (std::vector<double>{1.0, 0.0}));
  EXPECT_EQ(derived->fixed(), (std::vector<std::uint8_t>{0, 1}));
  EXPECT_EQ(framework->masses(), (std::vector<double>{12.0, 12.0}));
}

}  // namespace ragdoll::test
