// Tests for core/src/resolver_templates.cpp and rigid_units.cpp.

#include <gtest/gtest.h>

#include <algorithm>  // find
#include <set>

#include "examples.h"
#include "molecules.h"
#include "ragdoll/build_framework.h"
#include "ragdoll/resolver.h"
#include "ragdoll/rigid_units.h"

namespace ragdoll {
namespace {

using namespace examples;

std::shared_ptr<const Framework> framework_of_molecule(const Molecule& molecule) {
  return std::make_shared<const Framework>(build_framework(molecule));
}

Positions shaken(Positions x, double size, Random& random) {
  for (Vec3& point : x) point += 2 * size * random_vector(random);
  return x;
}

ResolverSettings templates(double tolerance = 1e-3) {
  ResolverSettings settings;
  settings.solver = "templates";
  settings.tolerance = tolerance;
  return settings;
}

TEST(RigidUnits, HoldEveryBarAndNoPairWithoutOne) {
  for (const Molecule& molecule : {methylacetamide(), heptane(), benzene()}) {
    const auto framework = framework_of_molecule(molecule);
    std::set<std::pair<int, int>> bars, held;
    for (const Bar& bar : framework->bars()) bars.insert(std::minmax(bar.p, bar.q));
    for (const RigidUnit& unit : find_rigid_units(*framework))
      for (const int p : unit.joints)
        for (const int q : unit.joints)
          if (p < q) held.insert({p, q});
    EXPECT_EQ(held, bars);
  }
}

TEST(RigidUnits, HaveTheShapeAndHandOfTheInput) {
  const Molecule molecule = heptane();
  const auto framework = framework_of_molecule(molecule);
  bool solid = false;
  for (const RigidUnit& unit : find_rigid_units(*framework)) {
    const auto at = [&](std::size_t k) {
      return molecule.positions()[std::size_t(unit.joints[k])];
    };
    for (std::size_t i = 0; i < unit.joints.size(); ++i)
      for (std::size_t j = i + 1; j < unit.joints.size(); ++j)
        EXPECT_NEAR((unit.shape[j] - unit.shape[i]).norm(), (at(j) - at(i)).norm(), 1e-9);
    if (unit.joints.size() < 4 || unit.either_hand) continue;
    const double volume = signed_volume(unit.shape[0], unit.shape[1], unit.shape[2], unit.shape[3]);
    EXPECT_NEAR(volume, signed_volume(at(0), at(1), at(2), at(3)), 1e-9);
    solid |= std::abs(volume) > 1e-4;
  }
  EXPECT_TRUE(solid);
}

TEST(RigidUnits, AreSingleBarsInATreeAndWholeInATetrahedron) {
  const Positions corners = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  EXPECT_EQ(find_rigid_units(Framework(parts_of("ab bc cd", corners))).size(), 3U);
  const auto whole = find_rigid_units(Framework(parts_of("ab ac ad bc bd cd", corners)));
  ASSERT_EQ(whole.size(), 1U);
  EXPECT_TRUE(whole[0].either_hand);
  EXPECT_EQ(find_rigid_units(Framework(parts_of("ab ac ad bc bd cd", corners)), 3).size(), 3U);
}

TEST(Templates, ResolveBarsOfRandomStructures) {
  Random random(5, RandomStream::generate, 0);
  for (int round = 0; round < 20; ++round) {
    const Structure structure = random_structure(12, round % 4, random);
    const auto framework = framework_of(structure.parts);
    Positions x = shaken(structure.positions, 0.02, random);
    const auto resolver = make_resolver(framework, templates());
    const ResolveReport report = resolver->resolve(x, {});
    ASSERT_TRUE(report.converged) << report.worst;
    EXPECT_LE(worst_violation(*framework, x, nullptr).relative, 1e-3);
    EXPECT_EQ(report.bar_visits, report.iterations * std::int64_t(framework->bars().size()));
    EXPECT_NEAR(report.residual, worst_violation(*framework, x, nullptr).relative, 1e-12);
  }
}

TEST(Templates, ResolveAMoleculeWithItsHandsContactsAndPlanes) {
  Random random(6, RandomStream::generate, 0);
  const Molecule molecule = heptane();
  const auto framework = framework_of_molecule(molecule);
  const auto resolver = make_resolver(framework, templates());
  EXPECT_EQ(resolver->solver(), "templates");
  for (int round = 0; round < 50; ++round) {
    Positions x = shaken(molecule.positions(), 0.015, random);
    const ResolveReport report = resolver->resolve(x, {});
    ASSERT_TRUE(report.converged) << report.worst;
    EXPECT_LE(worst_violation(*framework, x, nullptr).relative, 1e-3);
    EXPECT_EQ(inverted_centres(*framework, x), 0);
    EXPECT_GT(report.iterations, 1);
  }
}

TEST(Templates, ABodyThatMovedAsAWholeIsLeftWhereItIs) {
  const Molecule molecule = methylacetamide();
  const auto framework = framework_of_molecule(molecule);
  Positions x = molecule.positions();
  for (Vec3& point : x) point += Vec3(1, 2, 3);
  const Positions before = x;
  const ResolveReport report = make_resolver(framework, templates())->resolve(x, {});
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.iterations, 0);
  EXPECT_EQ(report.reason, StopReason::nothing_broken);
  EXPECT_EQ(x, before);
}

TEST(Templates, DoNotMoveFixedJoints) {
  Random random(7, RandomStream::generate, 0);
  Structure structure = random_structure(8, 0, random);
  structure.parts.fixed.assign(8, 0);
  structure.parts.fixed[2] = 1;
  Positions x = shaken(structure.positions, 0.05, random);
  x[2] = structure.positions[2];
  const ResolveReport report =
      make_resolver(framework_of(structure.parts), templates())->resolve(x, {});
  EXPECT_TRUE(report.converged) << report.worst;
  EXPECT_EQ(x[2], structure.positions[2]);
}

TEST(Templates, WhatCannotBeIsReportedAsNotConverged) {
  // a triangle whose sides do not close
  FrameworkParts parts = parts_of("ab bc ac", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  parts.bars[2].length = 3;
  Positions x = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  ResolverSettings settings = templates();
  settings.max_iterations = 50;
  const ResolveReport report = make_resolver(framework_of(parts), settings)->resolve(x, {});
  EXPECT_FALSE(report.converged);
  EXPECT_EQ(report.reason, StopReason::max_iterations);
  EXPECT_EQ(report.iterations, 50);
  EXPECT_NE(report.worst, "");
}

}  // namespace
}  // namespace ragdoll
