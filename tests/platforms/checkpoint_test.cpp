// Checkpoints and saved states continue a simulation bit for bit.

#include <sstream>

#include "platforms.h"

namespace ragdoll::test {

class Checkpoints : public OnPlatform {
 protected:
  void SetUp() override {
    OnPlatform::SetUp();
    if (platform == nullptr) return;
    integrator.setFramework(chainWithContacts(6));
    integrator.setOrder("random");
    integrator.setVerletScope("all");
    integrator.setPerturbation("gaussian");
    context = std::make_unique<OpenMM::Context>(*system, integrator, *platform);
    context->setPositions(straight(6));
    integrator.step(7);
    integrator.setJointForce(2, {0, 3e4, 0});
  }

  std::unique_ptr<OpenMM::System> system = particles(6);
  RagdollIntegrator integrator{0.002};
  std::unique_ptr<OpenMM::Context> context;
};
ON_EVERY_PLATFORM(Checkpoints);

TEST_P(Checkpoints, ACheckpointContinuesBitForBitWithForcesAndCounters) {
  std::stringstream checkpoint;
  context->createCheckpoint(checkpoint);
  const long long iterations = integrator.getIterations();
  integrator.step(9);
  const Positions expected = positionsOf(*context);

  context->loadCheckpoint(checkpoint);
  EXPECT_EQ(integrator.getAttemptedSteps(), 7);
  EXPECT_EQ(integrator.getIterations(), iterations);
  EXPECT_EQ(integrator.getStopReason(), "within tolerance");
  EXPECT_EQ(integrator.getJointForces().size(), 3U);
  integrator.step(9);
  EXPECT_EQ(positionsOf(*context), expected);
  EXPECT_EQ(integrator.getAttemptedSteps(), 16);
}

TEST_P(Checkpoints, ReinitializingWithItsStateKeptContinuesBitForBit) {
  std::stringstream checkpoint;
  context->createCheckpoint(checkpoint);
  integrator.step(5);
  const Positions expected = positionsOf(*context);
  context->loadCheckpoint(checkpoint);
  context->reinitialize(true);
  integrator.step(5);
  EXPECT_EQ(positionsOf(*context), expected);
  EXPECT_EQ(integrator.getAttemptedSteps(), 12);
}

TEST_P(Checkpoints, ReinitializingWithoutItForgetsPositionsAndCounters) {
  context->reinitialize();
  EXPECT_EQ(integrator.getAttemptedSteps(), 0);
  EXPECT_EQ(integrator.getStopReason(), "no step taken");
  EXPECT_THROW(integrator.step(1), OpenMM::OpenMMException);
}

TEST_P(Checkpoints, AStateContinuesBitForBitInAnotherContext) {
  const State saved =
      context->getState(State::Positions | State::Velocities | State::IntegratorParameters);
  integrator.step(4);
  std::stringstream xml;
  OpenMM::XmlSerializer::serialize(&saved, "State", xml);
  const std::unique_ptr<State> loaded(OpenMM::XmlSerializer::deserialize<State>(xml));

  const std::unique_ptr<RagdollIntegrator> other(
      OpenMM::XmlSerializer::clone<RagdollIntegrator>(integrator));
  OpenMM::Context second(*system, *other, *platform);
  second.setState(*loaded);
  EXPECT_EQ(other->getAttemptedSteps(), 7);
  other->step(4);
  EXPECT_EQ(positionsOf(second), positionsOf(*context));
}

TEST(StepReports, KeepAnyTextThroughXmlAndCheckpoints) {
  StepReport report;
  report.worstConstraint = "bar <a>\n & \"b\" is too long";
  OpenMM::SerializationNode node;
  report.writeTo(node);
  EXPECT_EQ(StepReport::readFrom(node).worstConstraint, report.worstConstraint);
  std::stringstream stream;
  report.writeTo(stream);
  EXPECT_EQ(StepReport::readFrom(stream).worstConstraint, report.worstConstraint);
  EXPECT_THROW(StepReport::readFrom(stream), OpenMM::OpenMMException);
}

}  // namespace ragdoll::test
