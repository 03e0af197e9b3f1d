// FrameworkForce: molecules without bonded forces.

#include "ragdoll/FrameworkForce.h"

#include "platforms.h"

namespace ragdoll::test {

class FrameworkForces : public OnPlatform {};
ON_EVERY_PLATFORM(FrameworkForces);

TEST_P(FrameworkForces, BarsOfBondsMakeTheMolecules) {
  auto system = particles(5);
  FrameworkParts parts = chainParts(3);
  parts.masses.assign(5, 12.0);
  parts.bars.push_back({3, 4, 0.15, BarKind::angle});
  system->addForce(new FrameworkForce(std::make_shared<const Framework>(parts)));
  OpenMM::VerletIntegrator integrator(0.001);
  OpenMM::Context context(*system, integrator, *platform);
  EXPECT_EQ(context.getMolecules(), (std::vector<std::vector<int>>{{0, 1, 2}, {3}, {4}}));
}

TEST_P(FrameworkForces, ItHasNoForceAndNoEnergyAndSaysWhetherItIsPeriodic) {
  auto system = particles(3);
  auto* force = new FrameworkForce(chain(3));
  system->addForce(force);
  EXPECT_FALSE(system->usesPeriodicBoundaryConditions());
  force->setUsesPeriodicBoundaryConditions(true);
  EXPECT_TRUE(system->usesPeriodicBoundaryConditions());
  OpenMM::VerletIntegrator integrator(0.001);
  OpenMM::Context context(*system, integrator, *platform);
  context.setPositions(straight(3));
  const State state = context.getState(State::Energy | State::Forces);
  EXPECT_EQ(state.getPotentialEnergy(), 0);
  EXPECT_EQ(state.getForces(), Positions(3));
}

TEST_P(FrameworkForces, WithoutAFrameworkOfTheSystemsSizeThereIsNoContext) {
  for (const auto& framework : {std::shared_ptr<const Framework>(), chain(2)}) {
    auto system = particles(3);
    system->addForce(new FrameworkForce(framework));
    OpenMM::VerletIntegrator integrator(0.001);
    EXPECT_THROW(OpenMM::Context(*system, integrator, *platform), OpenMM::OpenMMException);
  }
}

}  // namespace ragdoll::test
