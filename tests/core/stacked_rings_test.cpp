// Tests for core/src/stacked_rings.cpp.

#include "ragdoll/stacked_rings.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>  // AngleAxisd
#include <limits>
#include <numbers>  // pi
#include <set>

#include "examples.h"
#include "molecules.h"
#include "ragdoll/error.h"  // Error

namespace ragdoll {
namespace {

using namespace examples;

/// Two benzenes: the second tilted, and moved from the first.
Molecule benzenes(const Vec3& offset, double tilt_degree = 0) {
  const Molecule one = benzene();
  std::vector<Atom> atoms = one.atoms();
  std::vector<Bond> bonds = one.bonds();
  Positions x = one.positions();
  const int n = int(atoms.size());
  const Eigen::AngleAxisd tilt(tilt_degree * std::numbers::pi / 180, Vec3::UnitX());
  atoms.insert(atoms.end(), one.atoms().begin(), one.atoms().end());
  for (const Bond& bond : one.bonds()) bonds.push_back({bond.a + n, bond.b + n, bond.order});
  for (const Vec3& place : one.positions()) x.push_back(tilt * place + offset);
  return Molecule(atoms, bonds, x);
}

TEST(StackedRings, ParallelRingsAboveEachOtherAreHeldByThreePairsOfDifferentAtoms) {
  const auto pairs = stacked_rings(benzenes({0.1, 0, 0.35}));
  ASSERT_EQ(pairs.size(), 3U);
  std::set<int> atoms;
  for (const StackedPair& pair : pairs) {
    EXPECT_LT(pair.a, 6);
    EXPECT_GE(pair.b, 12);
    EXPECT_LT(pair.b, 18);
    atoms.insert({pair.a, pair.b});
    EXPECT_GE(pair.bound, pair.distance);
    EXPECT_NEAR(pair.bound, 0.39, 1e-9);  // 2 x 0.17 and the margin
  }
  EXPECT_EQ(atoms.size(), 6U);
}

TEST(StackedRings, RingsFarAwayTiltedOrSideBySideAreNotStacked) {
  EXPECT_EQ(stacked_rings(benzenes({0, 0, 0.54})).size(), 3U);
  EXPECT_TRUE(stacked_rings(benzenes({0, 0, 0.56})).empty());
  EXPECT_EQ(stacked_rings(benzenes({0, 0, 0.40}, 29)).size(), 3U);
  EXPECT_TRUE(stacked_rings(benzenes({0, 0, 0.40}, 31)).empty());
  EXPECT_TRUE(stacked_rings(benzenes({0.52, 0, 0.1})).empty());
}

TEST(StackedRings, WhatIsFartherThanTheMarginKeepsItsDistance) {
  for (const StackedPair& pair : stacked_rings(benzenes({0, 0, 0.5})))
    EXPECT_DOUBLE_EQ(pair.bound, pair.distance);
}

TEST(StackedRings, FlatRingsAlone) {
  EXPECT_TRUE(stacked_rings(benzene()).empty());
  EXPECT_TRUE(stacked_rings(cyclopentane_ring()).empty());
}

TEST(StackedRings, OptionsThatAreNoNumbersAreRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(stacked_rings(benzene(), {.distance = nan}), Error);
  EXPECT_THROW(stacked_rings(benzene(), {.angle_degree = nan}), Error);
  EXPECT_THROW(stacked_rings(benzene(), {.margin = nan}), Error);
}

}  // namespace
}  // namespace ragdoll
