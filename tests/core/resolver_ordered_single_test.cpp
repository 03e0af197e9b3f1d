// Tests for core/src/resolver_ordered.cpp and pass_frame.cpp: precision single.

#include <gtest/gtest.h>

#include "ordered_examples.h"

namespace ragdoll {
namespace {

using namespace examples;

constexpr Precision single = Precision::single;

TEST(OrderedSingle, HoldsTheToleranceInDoubles) {
  Random random = dice(21);
  for (const double tolerance : {1e-2, 1e-3, 1e-4})
    for (int round = 0; round < 30; ++round) {
      const Structure structure = random_structure(10 + round, round % 4, random);
      Positions x = structure.positions;
      for (Vec3& point : x) point += 0.3 * random_vector(random);
      const ResolveReport report =
          resolve(structure.parts, x,
                  {.tolerance = tolerance, .max_iterations = 100000, .precision = single});
      ASSERT_TRUE(report.converged) << report.worst;
      EXPECT_LE(worst_of(structure.parts, x), tolerance);
      EXPECT_DOUBLE_EQ(worst_of(structure.parts, x), report.residual);
    }
}

TEST(OrderedSingle, FindsWhatDoublesFind) {
  Random random = dice(22);
  const Structure structure = random_structure(20, 2, random);
  Positions x = structure.positions, y = x;
  x[3] += random_vector(random);
  y[3] = x[3];
  const ResolveReport one = resolve(structure.parts, x, {.tolerance = 1e-4}, {3});
  const ResolveReport two =
      resolve(structure.parts, y, {.tolerance = 1e-4, .precision = single}, {3});
  EXPECT_NEAR(double(one.iterations), double(two.iterations), 2);
  for (std::size_t j = 0; j < x.size(); ++j) EXPECT_LE((x[j] - y[j]).norm(), 1e-4);
  // but not in all its digits
  EXPECT_NE(x, y);
}

TEST(OrderedSingle, FarAwayCoordinatesKeepTheirDigits) {
  Random random = dice(23);
  const Structure structure = random_structure(20, 2, random);
  Positions x = structure.positions;
  for (Vec3& point : x) point += Vec3(1e5, -1e5, 3e4) + 0.2 * random_vector(random);
  const ResolveReport report =
      resolve(structure.parts, x, {.tolerance = 1e-4, .precision = single});
  EXPECT_TRUE(report.converged);
  EXPECT_LE(worst_of(structure.parts, x), 1e-4);
}

TEST(OrderedSingle, JointsThatDoNotMoveKeepTheirBits) {
  Random random = dice(24);
  Structure structure = random_structure(20, 1, random);
  structure.parts.fixed.assign(20, 0);
  structure.parts.fixed[5] = 1;
  Positions x = structure.positions;
  EXPECT_EQ(resolve(structure.parts, x, {.precision = single}).reason, StopReason::nothing_broken);
  EXPECT_EQ(x, structure.positions);
  for (Vec3& point : x) point += 0.1 * random_vector(random);
  x[5] = structure.positions[5];
  EXPECT_TRUE(resolve(structure.parts, x, {.precision = single}).converged);
  EXPECT_EQ(x[5], structure.positions[5]);
}

TEST(OrderedSingle, BreaksThatFloatsCannotHoldAreResolvedInDoubles) {
  Random random = dice(25);
  const Structure structure = random_structure(12, 0, random);
  for (const double size : {1e3, 1e6, 1e25}) {
    Positions x = structure.positions;
    x[4] += size * random_vector(random);
    Positions y = x;
    const ResolverSettings settings = {.weighting = far_only, .tolerance = 1e-4};
    ResolverSettings in_floats = settings;
    in_floats.precision = single;
    const bool converged = resolve(structure.parts, x, settings, {4}).converged;
    EXPECT_EQ(resolve(structure.parts, y, in_floats, {4}).converged, converged);
    EXPECT_EQ(converged, size < 1e20);
    EXPECT_EQ(x, y);
  }
}

TEST(OrderedSingle, ToleranceThatFloatsCannotHoldIsRefused) {
  const FrameworkParts parts = parts_of("ab bc", {{0, 0, 0}, {1, 0, 0}, {1, 4, 0}});
  const auto refusal = [&](Tolerance tolerance) {
    return refusal_of([&] {
      make_resolver(framework_of(parts),
                    {.solver = "ordered", .tolerance = tolerance, .precision = single});
    });
  };
  EXPECT_EQ(refusal(1e-5), "");
  EXPECT_EQ(refusal(1e-6),
            "precision single holds tolerances of 1e-05 or more here; choose one, or precision "
            "double");
  EXPECT_EQ(refusal(Tolerance::nanometers(4e-5)), "");
  EXPECT_EQ(refusal(Tolerance::nanometers(1e-5)),
            "precision single holds tolerances of 4e-05 nm or more here; choose one, or precision "
            "double");
}

TEST(OrderedSingle, ContradictionsAreReported) {
  FrameworkParts parts;
  parts.masses.assign(3, 1);
  parts.bars = {{0, 1, 1}, {1, 2, 1}, {2, 0, 5}};
  Positions x = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}};
  const ResolveReport report = resolve(parts, x, {.max_iterations = 100, .precision = single});
  EXPECT_FALSE(report.converged);
  EXPECT_EQ(report.reason, StopReason::max_iterations);
  EXPECT_EQ(report.worst.substr(0, 4), "bar ");
}

}  // namespace
}  // namespace ragdoll
