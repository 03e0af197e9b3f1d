// What the tests of this folder share: platforms, small systems, and reading positions.

#pragma once
#include <OpenMM.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "ragdoll/RagdollIntegrator.h"  // RagdollIntegrator

namespace ragdoll::test {

using OpenMM::State;
using Positions = std::vector<OpenMM::Vec3>;

/// The platform of that name, with ragdoll's kernels; null if this machine has none.
OpenMM::Platform* findPlatform(const std::string& name);

/// A test that runs on each platform and is skipped where there is none.
class OnPlatform : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override;
  OpenMM::Platform* platform = nullptr;
};

#define ON_EVERY_PLATFORM(Fixture)                                                  \
  INSTANTIATE_TEST_SUITE_P(Platforms, Fixture, testing::Values("Reference", "CPU"), \
                           [](const auto& parameter) { return std::string(parameter.param); })

/// A framework of a chain: joints of 12 dalton, bars of 0.15 nm.
FrameworkParts chainParts(int joints);
std::shared_ptr<const Framework> chain(int joints);

/// A chain whose joints may not come closer than 0.17 nm, unless a bar joins them.
std::shared_ptr<const Framework> chainWithContacts(int joints);

/// The chain's joints along x.
Positions straight(int joints);

/// A System of particles of 12 dalton without forces.
std::unique_ptr<OpenMM::System> particles(int count);

double distance(const OpenMM::Vec3& a, const OpenMM::Vec3& b);
Positions positionsOf(const OpenMM::Context& context);
Positions velocitiesOf(const OpenMM::Context& context);

/// Largest |d - L| / L over the bars.
double largestViolation(const Framework& framework, const Positions& positions);

}  // namespace ragdoll::test
