// What a step does: Verlet, perturbations, forces, counters.

#include <cmath>
#include <limits>

#include "platforms.h"

namespace ragdoll::test {

class Steps : public OnPlatform {};
ON_EVERY_PLATFORM(Steps);

TEST_P(Steps, FreeFlightUnderAConstantForceFollowsVerletsClosedForm) {
  auto system = particles(1);
  FrameworkParts parts;
  parts.masses = {12.0};
  const double dt = 0.002, force = 30, v0 = 0.4;
  RagdollIntegrator integrator(dt);
  integrator.setFramework(std::make_shared<const Framework>(parts));
  integrator.setVerletScope("all");
  OpenMM::Context context(*system, integrator, *platform);
  context.setPositions({{1, 2, 3}});
  context.setVelocities({{v0, 0, 0}});
  const int n = 100;
  for (int step = 0; step < n; ++step) {
    integrator.setJointForce(0, {0, force, 0});
    integrator.step(1);
  }
  const OpenMM::Vec3 end = positionsOf(context)[0];
  EXPECT_NEAR(end[0], 1 + v0 * n * dt, 1e-12);
  EXPECT_NEAR(end[1], 2 + force / 12 * dt * dt * n * (n + 1) / 2, 1e-12);
  EXPECT_EQ(end[2], 3);
  EXPECT_NEAR(velocitiesOf(context)[0][1], force / 12 * dt * n, 1e-9);
  EXPECT_NEAR(context.getState(State::Positions).getTime(), n * dt, 1e-12);
  EXPECT_EQ(context.getStepCount(), n);
}

TEST_P(Steps, ForcesOfTheSystemActOnlyIfAskedForAndOnlyThoseOfTheForceGroups) {
  auto system = particles(1);
  auto* pull = new OpenMM::CustomExternalForce("-24*x");
  pull->addParticle(0, {});
  auto* other = new OpenMM::CustomExternalForce("-1000*x");
  other->addParticle(0, {});
  other->setForceGroup(3);
  system->addForce(pull);
  system->addForce(other);
  RagdollIntegrator integrator(0.01);
  integrator.setFramework(chain(1));
  integrator.setIntegrationForceGroups(1 << 0);
  OpenMM::Context context(*system, integrator, *platform);
  context.setPositions({{0, 0, 0}});
  integrator.step(1);
  EXPECT_EQ(positionsOf(context)[0][0], 0);
  integrator.setUseSystemForces(true);
  integrator.step(1);
  EXPECT_NEAR(positionsOf(context)[0][0], 24.0 / 12 * 1e-4, 1e-9);
}

TEST_P(Steps, APulledJointTakesItsChainAlongAndEveryBarStaysWithinTolerance) {
  const int n = 12;
  auto system = particles(n);
  RagdollIntegrator integrator(0.002);
  integrator.setFramework(chain(n));
  integrator.setConstraintTolerance(1e-6);
  OpenMM::Context context(*system, integrator, *platform);
  context.setPositions(straight(n));
  for (int step = 0; step < 50; ++step) {
    integrator.setJointForce(n - 1, {0, 20000, 5000});
    integrator.step(1);
    ASSERT_TRUE(integrator.getConverged()) << integrator.getWorstConstraint();
    EXPECT_GT(integrator.getIterations(), 0);
    EXPECT_LE(integrator.getResidual(), 1e-6);
  }
  EXPECT_GT(positionsOf(context)[n - 1][1], 0.1);
  EXPECT_GT(positionsOf(context)[n - 2][1], 0.01);
  EXPECT_LE(largestViolation(*integrator.getFramework(), positionsOf(context)), 1e-6 + 1e-12);
}

TEST_P(Steps, ATreeResolvedFromItsForcedJointTakesOneIteration) {
  auto system = particles(6);
  RagdollIntegrator integrator(0.002);
  integrator.setFramework(chain(6));
  integrator.setSolver("ordered");
  integrator.setOrder("bfs_tree");
  integrator.setWeighting("1/0");
  OpenMM::Context context(*system, integrator, *platform);
  context.setPositions(straight(6));
  integrator.setJointForce(5, {0, 50000, 0});
  integrator.step(1);
  EXPECT_TRUE(integrator.getConverged());
  EXPECT_EQ(integrator.getIterations(), 1);
  EXPECT_EQ(integrator.getBarVisits(), 5);
}

TEST_P(Steps, AJointForceLastsForOneStep) {
  auto system = particles(1);
  RagdollIntegrator integrator(0.01);
  integrator.setFramework(chain(1));
  OpenMM::Context context(*system, integrator, *platform);
  context.setPositions({{0, 0, 0}});
  integrator.setJointForces({{120, 0, 0}});
  integrator.step(3);
  EXPECT_TRUE(integrator.getJointForces().empty());
  EXPECT_NEAR(positionsOf(context)[0][0], 10 * 1e-4, 1e-15);
  integrator.setJointForce(0, {120, 0, 0});
  integrator.clearJointForces();
  integrator.step(1);
  EXPECT_NEAR(positionsOf(context)[0][0], 10 * 1e-4, 1e-15);
}

TEST_P(Steps, TwentyStepsAtOnceAreTwentySingleStepsBitForBit) {
  auto run = [&](int chunk) {
    auto system = particles(8);
    RagdollIntegrator integrator(0.002);
    integrator.setFramework(chainWithContacts(8));
    integrator.setOrder("random");
    integrator.setVerletScope("all");
    integrator.setPerturbation("gaussian");
    integrator.setPerturbationSize(0.005);
    integrator.setRandomNumberSeed(7);
    OpenMM::Context context(*system, integrator, *platform);
    context.setPositions(straight(8));
    for (int step = 0; step < 20; step += chunk) integrator.step(chunk);
    return positionsOf(context);
  };
  EXPECT_EQ(run(20), run(1));
}

TEST_P(Steps, TheSeedAddressesThePerturbation) {
  auto run = [&](int seed) {
    auto system = particles(3);
    RagdollIntegrator integrator(0.002);
    integrator.setFramework(chain(3));
    integrator.setPerturbation("ball");
    integrator.setRandomNumberSeed(seed);
    OpenMM::Context context(*system, integrator, *platform);
    context.setPositions(straight(3));
    integrator.step(2);
    return positionsOf(context);
  };
  EXPECT_EQ(run(0), run(0));
  EXPECT_NE(run(0), run(1));
  EXPECT_NE(run(-1), run(1));
}

TEST_P(Steps, AParameterSetDuringASimulationTakesEffectAtTheNextStep) {
  auto system = particles(2);
  RagdollIntegrator integrator(0.002);
  integrator.setFramework(chain(2));
  OpenMM::Context context(*system, integrator, *platform);
  context.setPositions({{0, 0, 0}, {0.15, 0, 0}});
  integrator.step(1);
  EXPECT_EQ(integrator.getIterations(), 0);
  EXPECT_EQ(integrator.getStopReason(), "nothing broken");
  FrameworkParts longer = chainParts(2);
  longer.bars[0].length = 0.2;
  integrator.setFramework(std::make_shared<const Framework>(longer));
  integrator.setConstraintTolerance(0.5);
  integrator.step(1);
  EXPECT_NEAR(distance(positionsOf(context)[0], positionsOf(context)[1]), 0.15, 1e-12);
  integrator.setConstraintTolerance(1e-9);
  integrator.step(1);
  EXPECT_NEAR(distance(positionsOf(context)[0], positionsOf(context)[1]), 0.2, 1e-9);
}

TEST_P(Steps, AnUnresolvedStepIsReportedAndKeptUnlessItIsToBeRejected) {
  auto system = particles(3);
  FrameworkParts impossible = chainParts(3);
  impossible.bars.push_back({0, 2, 1.0, BarKind::bond});
  RagdollIntegrator integrator(0.002);
  integrator.setFramework(std::make_shared<const Framework>(impossible));
  integrator.setMaxIterations(20);
  OpenMM::Context context(*system, integrator, *platform);
  context.setPositions(straight(3));
  context.setVelocities({{1, 0, 0}, {0, 1, 0}, {0, 0, 1}});

  integrator.setRejectUnresolved(true);
  integrator.step(2);
  EXPECT_FALSE(integrator.getConverged());
  EXPECT_FALSE(integrator.getAccepted());
  EXPECT_GT(integrator.getResidual(), 0.01);
  EXPECT_FALSE(integrator.getWorstConstraint().empty());
  EXPECT_EQ(positionsOf(context), straight(3));
  EXPECT_EQ(velocitiesOf(context)[1], OpenMM::Vec3(0, 1, 0));
  EXPECT_EQ(context.getStepCount(), 2);
  EXPECT_EQ(integrator.getAttemptedSteps(), 2);
  EXPECT_EQ(integrator.getRejectedSteps(), 2);

  integrator.setRejectUnresolved(false);
  integrator.step(1);
  EXPECT_FALSE(integrator.getConverged());
  EXPECT_TRUE(integrator.getAccepted());
  EXPECT_NE(positionsOf(context), straight(3));
  EXPECT_EQ(integrator.getRejectedSteps(), 2);
}

TEST_P(Steps, AStepThatMirrorsAChiralityCentreIsTakenBack) {
  auto system = particles(4);
  FrameworkParts parts;
  parts.masses.assign(4, 12.0);
  Volume volume;
  volume.a = 0, volume.b = 1, volume.c = 2, volume.d = 3;
  volume.lower = 0.5e-3, volume.upper = 2e-3, volume.scale = 1e-3;
  parts.volumes = {volume};
  RagdollIntegrator integrator(0.002);
  integrator.setFramework(std::make_shared<const Framework>(parts));
  integrator.setMaxIterations(1);
  integrator.setConstraintTolerance(1e-9);
  integrator.setRejectUnresolved(true);
  OpenMM::Context context(*system, integrator, *platform);
  const Positions mirrored = {{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}, {0, 0, -5}};
  context.setPositions(mirrored);
  integrator.step(1);
  EXPECT_FALSE(integrator.getAccepted());
  EXPECT_EQ(integrator.getInvertedCentres(), 1);
  EXPECT_EQ(positionsOf(context), mirrored);
}

TEST_P(Steps, PositionsThatAreNoNumbersAreReportedAndDoNotHang) {
  auto system = particles(4);
  RagdollIntegrator integrator(0.002);
  integrator.setFramework(chainWithContacts(4));
  OpenMM::Context context(*system, integrator, *platform);
  Positions positions = straight(4);
  positions[2][1] = std::numeric_limits<double>::quiet_NaN();
  context.setPositions(positions);
  integrator.step(3);
  EXPECT_FALSE(integrator.getConverged());
  positions[2][1] = 1e300;
  context.setPositions(positions);
  integrator.step(1);
  EXPECT_FALSE(integrator.getConverged());
}

TEST_P(Steps, VelocitiesSetToATemperatureMoveJointsAndGiveThatKineticEnergy) {
  const int n = 2000;
  auto system = particles(n);
  FrameworkParts parts;
  parts.masses.assign(std::size_t(n), 12.0);
  RagdollIntegrator integrator(0.002);
  integrator.setFramework(std::make_shared<const Framework>(parts));
  integrator.setVerletScope("all");
  OpenMM::Context context(*system, integrator, *platform);
  context.setPositions(straight(n));
  context.setVelocitiesToTemperature(300, 5);
  const double expected = 1.5 * n * 0.00831446261815324 * 300;
  EXPECT_NEAR(context.getState(State::Energy).getKineticEnergy(), expected, 0.1 * expected);
  integrator.step(10);
  EXPECT_NEAR(context.getState(State::Energy).getKineticEnergy(), expected, 0.1 * expected);
  EXPECT_NE(positionsOf(context)[0], straight(n)[0]);
}

TEST_P(Steps, ItTakesPartInACompoundIntegrator) {
  auto system = particles(2);
  OpenMM::CompoundIntegrator compound;
  auto* ragdoll = new RagdollIntegrator(0.002);
  ragdoll->setFramework(chain(2));
  compound.addIntegrator(ragdoll);
  compound.addIntegrator(new OpenMM::VerletIntegrator(0.001));
  OpenMM::Context context(*system, compound, *platform);
  context.setPositions(straight(2));
  ragdoll->setJointForce(0, {0, 0, 900});
  compound.step(1);
  compound.setCurrentIntegrator(1);
  compound.step(1);
  EXPECT_EQ(ragdoll->getAttemptedSteps(), 1);
  EXPECT_GT(positionsOf(context)[0][2], 0);
}

TEST_P(Steps, ContactsSeePeriodicImagesOfAPeriodicSystemOnly) {
  for (const bool periodic : {false, true}) {
    auto system = particles(2);
    auto* force = new OpenMM::CustomNonbondedForce("0");
    for (int i = 0; i < 2; ++i) force->addParticle({});
    force->setNonbondedMethod(periodic ? OpenMM::CustomNonbondedForce::CutoffPeriodic
                                       : OpenMM::CustomNonbondedForce::CutoffNonPeriodic);
    system->addForce(force);
    FrameworkParts parts = chainWithContacts(2)->parts();
    parts.bars.clear();
    parts.contact_rule.exclusions.clear();
    parts.contact_rule.exclusion_begin = {0, 0, 0};
    RagdollIntegrator integrator(0.002);
    integrator.setFramework(std::make_shared<const Framework>(parts));
    OpenMM::Context context(*system, integrator, *platform);
    context.setPeriodicBoxVectors({3, 0, 0}, {0, 3, 0}, {0, 0, 3});
    context.setPositions({{0.05, 0, 0}, {2.95, 0, 0}});
    integrator.step(1);
    const Positions moved = positionsOf(context);
    EXPECT_NEAR(moved[1][0] - moved[0][0], periodic ? 2.83 : 2.9, 1e-3);
  }
}

}  // namespace ragdoll::test
