// Tests for core/src/resolver_ordered.cpp: tethers, contacts and volumes.

#include <gtest/gtest.h>

#include <utility>  // pair

#include "ordered_examples.h"

namespace ragdoll {
namespace {

using namespace examples;

// === Tethers and contacts

TEST(Ordered, TethersAndContactsAreCorrectedOnlyWhenViolated) {
  FrameworkParts parts;
  parts.masses.assign(4, 1);
  parts.tethers = {{0, 1, 1}, {2, 3, 1}};
  Positions x = on_axis({0, 0.5, 10, 13});
  EXPECT_EQ(resolve(parts, x, {}).iterations, 1);
  EXPECT_EQ(x, on_axis({0, 0.5, 11, 12}));
  EXPECT_EQ(resolve(parts, x, {}).iterations, 0);

  parts.tethers.clear();
  parts.contacts = {{0, 1, 1}, {2, 3, 1}};
  x = on_axis({0, 0.5, 10, 13});
  EXPECT_EQ(resolve(parts, x, {}).iterations, 1);
  EXPECT_EQ(x, on_axis({-0.25, 0.75, 10, 13}));
}

TEST(Ordered, TethersAndContactsWithinToleranceAreLeft) {
  FrameworkParts parts;
  parts.masses.assign(4, 1);
  parts.tethers = {{0, 1, 1}};
  parts.contacts = {{2, 3, 1}};
  Positions x = on_axis({0, 1.009, 5, 5.991});
  EXPECT_EQ(resolve(parts, x, {.tolerance = 0.01}).iterations, 0);
  x = on_axis({0, 1.011, 5, 5.989});
  EXPECT_EQ(resolve(parts, x, {.tolerance = 0.01}).iterations, 1);
}

TEST(Ordered, TethersAreSharedEvenlyWhateverTheWeighting) {
  FrameworkParts parts;
  parts.masses = {1, 50};
  parts.tethers = {{0, 1, 1}};
  Positions x = on_axis({0, 3});
  resolve(parts, x, {.weighting = far_only}, {0});
  EXPECT_EQ(x, on_axis({1, 2}));
  parts.fixed = {1, 0};
  x = on_axis({0, 3});
  resolve(parts, x, {.weighting = far_only}, {0});
  EXPECT_EQ(x, on_axis({0, 1}));
}

TEST(Ordered, TethersComeAfterTheBarsInFileOrder) {
  FrameworkParts parts;
  parts.masses.assign(3, 1);
  // ab 2 -> a .5, b 1.5; bc 2.5 -> b 2.25, c 3.25
  parts.tethers = {{0, 1, 1}, {1, 2, 1}};
  Positions x = on_axis({0, 2, 4});
  const ResolveReport report = resolve(parts, x, {.max_iterations = 1});
  EXPECT_EQ(x, on_axis({0.5, 2.25, 3.25}));
  EXPECT_EQ(report.worst, "tether joint 0 - joint 1 is 1.75 nm long instead of at most 1");
  // a bar bc comes first: b 2.5, c 3.5; then ab 2.5 -> a .75, b 1.75
  parts.tethers = {{0, 1, 1}};
  parts.bars = {{1, 2, 1}};
  x = on_axis({0, 2, 4});
  resolve(parts, x, {.max_iterations = 1});
  EXPECT_EQ(x, on_axis({0.75, 1.75, 3.5}));
}

TEST(Ordered, ContactsComeAfterTheTethers) {
  FrameworkParts parts;
  parts.masses.assign(3, 1);
  // tether ab 2 -> a .5, b 1.5; contact bc .7 -> b 1.35, c 2.35
  parts.tethers = {{0, 1, 1}};
  parts.contacts = {{1, 2, 1}};
  Positions x = on_axis({0, 2, 2.2});
  resolve(parts, x, {.max_iterations = 1});
  EXPECT_NEAR(x[0][0], 0.5, 1e-15);
  EXPECT_NEAR(x[1][0], 1.35, 1e-15);
  EXPECT_NEAR(x[2][0], 2.35, 1e-15);
}

// === Volumes

const Positions corner = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};  // volume 1

TEST(Ordered, ViolatedVolumesComeBackToTheirBounds) {
  Random random = dice(14);
  for (const auto& [lower, upper] : {std::pair(2.0, infinity), std::pair(-infinity, -0.5),
                                     std::pair(-0.1, 0.1), std::pair(1.5, 1.6)}) {
    FrameworkParts parts;
    parts.masses.assign(4, 1);
    parts.volumes = {{0, 1, 2, 3, lower, upper, 1}};
    Positions x = corner;
    for (Vec3& point : x) point += 0.2 * random_vector(random);
    Vec3 sum = Vec3::Zero(), sum_after = Vec3::Zero();
    for (const Vec3& point : x) sum += point;
    const ResolveReport report = resolve(parts, x, {});
    for (const Vec3& point : x) sum_after += point;
    EXPECT_TRUE(report.converged);
    EXPECT_GT(report.iterations, 0);
    const double volume = signed_volume(x[0], x[1], x[2], x[3]);
    EXPECT_GE(volume, lower - 1e-3 - 1e-12);
    EXPECT_LE(volume, upper + 1e-3 + 1e-12);
    EXPECT_NEAR((sum - sum_after).norm(), 0, 1e-12);
  }
}

TEST(Ordered, VolumeWithinItsBoundsIsLeft) {
  FrameworkParts parts;
  parts.masses.assign(4, 1);
  parts.volumes = {{0, 1, 2, 3, 0.9, 1.1, 1}};
  Positions x = corner;
  EXPECT_EQ(resolve(parts, x, {}).iterations, 0);
  EXPECT_EQ(x, corner);
}

TEST(Ordered, InvertedCentreComesBackOrIsReported) {
  // a rigid tetrahedron, mirrored: its bars are whole, its volume is not
  FrameworkParts parts = parts_of("ab ac ad bc bd cd", corner);
  parts.volumes = {{0, 1, 2, 3, 0.5, infinity, 1}};
  Positions x = corner;
  x[3][2] = -1;
  const ResolveReport report = resolve(parts, x, {});
  EXPECT_GT(report.iterations, 0);
  if (report.converged)
    EXPECT_EQ(inverted_centres(Framework(parts), x), 0);
  else
    EXPECT_GT(report.residual, 1e-3);
}

TEST(Ordered, VolumeThatNothingCanMoveIsReported) {
  FrameworkParts parts;
  parts.masses.assign(4, 1);
  parts.volumes = {{0, 1, 2, 3, 0.5, infinity, 1}};
  Positions x = on_axis({0, 1, 2, 3});
  ResolveReport report = resolve(parts, x, {.max_iterations = 40});
  EXPECT_FALSE(report.converged);
  EXPECT_EQ(report.iterations, 40);
  EXPECT_EQ(report.worst.substr(0, 9), "chirality");
  parts.fixed.assign(4, 1);
  x = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0.1}};
  report = resolve(parts, x, {.max_iterations = 40});
  EXPECT_FALSE(report.converged);
}

// === Absolute tolerances

TEST(OrderedAbsolute, HoldsForEveryLengthAlike) {
  FrameworkParts parts;
  parts.masses.assign(4, 1);
  parts.bars = {{0, 1, 100}, {2, 3, 0.1}};
  const auto iterations = [&](double distance, double small) {
    Positions x = {{0, 0, 0}, {distance, 0, 0}, {0, 9, 0}, {small, 9, 0}};
    return resolve(parts, x, {.tolerance = Tolerance::nanometers(0.01)}).iterations;
  };
  EXPECT_EQ(iterations(100.009, 0.109), 0);
  EXPECT_EQ(iterations(100.011, 0.1), 1);
  EXPECT_EQ(iterations(100, 0.111), 1);
}

TEST(OrderedAbsolute, HoldsForTethersContactsAndVolumes) {
  FrameworkParts parts;
  parts.masses.assign(8, 1);
  parts.tethers = {{0, 1, 10}};
  parts.contacts = {{2, 3, 10}};
  parts.volumes = {{4, 5, 6, 7, 8.2, infinity, 8}};
  const auto iterations = [&](double tether, double contact, double nanometers) {
    // the volume is 8, and 0.2 nm^3 below its bound; over 8^(2/3) that is 0.05 nm
    const Positions start = {{0, 0, 0}, {tether, 0, 0}, {0, 5, 0}, {contact, 5, 0},
                             {0, 0, 0}, {2, 0, 0},      {0, 2, 0}, {0, 0, 2}};
    Positions x = start;
    return resolve(parts, x, {.tolerance = Tolerance::nanometers(nanometers)}).iterations;
  };
  EXPECT_EQ(iterations(10.05, 9.95, 0.051), 0);
  EXPECT_GT(iterations(10.06, 9.95, 0.051), 0);
  EXPECT_GT(iterations(10.05, 9.94, 0.051), 0);
  EXPECT_GT(iterations(10, 10, 0.049), 0);
}

TEST(OrderedAbsolute, LargestViolationsAreReportedAsRatioAndAsLength) {
  FrameworkParts parts;
  parts.masses.assign(4, 1);
  parts.bars = {{0, 1, 4}, {2, 3, 0.5}};
  Positions x = {{0, 0, 0}, {4.25, 0, 0}, {0, 9, 0}, {0.5625, 9, 0}};
  const ResolveReport report = resolve(parts, x, {.tolerance = 0.2});
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.residual, 0.125);
  EXPECT_EQ(report.residual_nm, 0.25);
}

}  // namespace
}  // namespace ragdoll
