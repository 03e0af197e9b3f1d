// Tests for core/src/resolver_ordered.cpp: what cannot be resolved, fixed and coincident joints.

#include <gtest/gtest.h>

#include <cmath>  // abs

#include "ordered_examples.h"

namespace ragdoll {
namespace {

using namespace examples;

// === Not resolved

TEST(Ordered, MaximumIsReportedWithTheWorstConstraint) {
  PulledChain chain;
  const ResolveReport report =
      resolve(chain.parts, chain.x, {.tolerance = 0.1, .max_iterations = 1}, {0});
  EXPECT_FALSE(report.converged);
  EXPECT_EQ(report.reason, StopReason::max_iterations);
  EXPECT_EQ(report.iterations, 1);
  EXPECT_EQ(report.bar_visits, 2);
  EXPECT_EQ(report.residual, 0.25);
  EXPECT_EQ(report.worst, "bar joint 0 - joint 1 is 1.25 nm long instead of 1");
  // the joints are where the last iteration left them
  EXPECT_EQ(chain.x, on_axis({-0.5, 0.75, 1.75}));
}

TEST(Ordered, MaximumThatIsJustEnoughIsConverged) {
  for (const OrderKind kind : all_kinds) {
    Random random = dice(10);
    const Structure structure = random_structure(10, is_tree_order(kind) ? 0 : 1, random);
    Positions broken = structure.positions;
    broken[2] += random_vector(random);
    Positions x = broken, y = broken, z = broken;
    const std::int64_t needed = resolve(structure.parts, x, {.order = kind}, {2}).iterations;
    ASSERT_GT(needed, 1);
    const ResolveReport enough =
        resolve(structure.parts, y, {.order = kind, .max_iterations = long(needed)}, {2});
    EXPECT_TRUE(enough.converged) << name_of(kind);
    EXPECT_EQ(enough.iterations, needed);
    EXPECT_EQ(enough.reason, StopReason::within_tolerance);
    EXPECT_EQ(x, y);
    const ResolveReport fewer =
        resolve(structure.parts, z, {.order = kind, .max_iterations = long(needed) - 1}, {2});
    EXPECT_FALSE(fewer.converged) << name_of(kind);
    EXPECT_EQ(fewer.iterations, needed - 1);
    EXPECT_NE(fewer.worst, "");
  }
}

TEST(Ordered, ImpossibleTriangleIsNotConverged) {
  FrameworkParts parts;
  parts.masses.assign(3, 1);
  parts.bars = {{0, 1, 1}, {1, 2, 1}, {2, 0, 5}};
  for (const OrderKind kind : all_kinds) {
    if (is_tree_order(kind)) continue;
    Positions x = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}};
    const ResolveReport report = resolve(parts, x, {.order = kind, .max_iterations = 100});
    EXPECT_FALSE(report.converged);
    EXPECT_EQ(report.iterations, 100);
    EXPECT_GT(report.residual, 0.1);
    EXPECT_EQ(report.worst.substr(0, 4), "bar ");
  }
}

TEST(Ordered, PositionsThatAreNoNumbersAreReportedAndLeftAlone) {
  for (const double bad : {nan, infinity, -infinity})
    for (const OrderKind kind : all_kinds) {
      PulledChain chain;
      chain.parts.contact_rule.radii.assign(3, 0.1);
      chain.parts.contact_rule.polarity.assign(3, Polarity::none);
      chain.parts.contact_rule.scale = 1;
      chain.parts.contact_rule.exclusion_begin.assign(4, 0);
      const auto resolver =
          make_resolver(framework_of(chain.parts), {.solver = "ordered", .order = kind});
      Positions x = chain.x;
      x[2][1] = bad;
      const ResolveReport report = resolver->resolve(x, {});
      EXPECT_FALSE(report.converged);
      EXPECT_EQ(report.reason, StopReason::not_finite);
      EXPECT_EQ(report.iterations, 0);
      EXPECT_NE(report.worst.find("joint 2"), std::string::npos);
      EXPECT_EQ(x[0], chain.x[0]);
      // the next break is resolved
      EXPECT_TRUE(resolver->resolve(chain.x, {}).converged);
    }
}

TEST(Ordered, OverflowIsReportedAndDoesNotHang) {
  for (const double huge : {1e160, 1e300, 1e308})
    for (const OrderKind kind : all_kinds) {
      const PulledChain chain;
      const auto resolver =
          make_resolver(framework_of(chain.parts), {.solver = "ordered", .order = kind});
      Positions x = chain.x, y = chain.x;
      x[0] = Vec3(-huge, huge, 0);
      const ResolveReport report = resolver->resolve(x, {});
      EXPECT_FALSE(report.converged);
      EXPECT_EQ(report.reason, StopReason::not_finite);
      EXPECT_LE(report.iterations, 1);
      // the next break is resolved
      EXPECT_TRUE(resolver->resolve(y, {}).converged);
    }
}

TEST(Ordered, ForcesOfAMillionAreResolvedOrReported) {
  Random random = dice(11);
  for (const int cycles : {0, 1, 2})
    for (const OrderKind kind : all_kinds)
      for (const Weighting& weighting : weightings) {
        if (is_tree_order(kind) && cycles > 0) continue;
        const Structure structure = random_structure(10, cycles, random);
        Positions x = structure.positions;
        x[6] += 1e6 * random_vector(random);
        const ResolveReport report =
            resolve(structure.parts, x,
                    {.order = kind, .weighting = weighting, .max_iterations = 1000}, {6});
        EXPECT_EQ(report.converged, worst_of(structure.parts, x) <= 1e-3 * (1 + 1e-9));
        EXPECT_NE(report.reason, StopReason::not_finite);
        EXPECT_GT(report.iterations, 0);
        if (cycles == 0 && weighting.far == 1 && kind != OrderKind::random) {
          EXPECT_TRUE(report.converged);
          EXPECT_EQ(report.iterations, 1);
        }
      }
}

// === Fixed and coincident joints

TEST(Ordered, FixedEndTakesNoShareAndTheOtherTheWhole) {
  for (const Weighting& weighting : weightings) {
    FrameworkParts parts;
    parts.masses.assign(2, 1);
    parts.bars = {{0, 1, 1}};
    parts.fixed = {1, 0};
    Positions x = on_axis({0, 3});
    EXPECT_EQ(resolve(parts, x, {.weighting = weighting}, {1}).iterations, 1);
    EXPECT_EQ(x, on_axis({0, 1}));
    parts.fixed = {0, 1};
    x = on_axis({0, 3});
    EXPECT_EQ(resolve(parts, x, {.weighting = weighting}, {1}).iterations, 1);
    EXPECT_EQ(x, on_axis({2, 3}));
  }
}

TEST(Ordered, BarBetweenFixedJointsIsSkippedAndReported) {
  FrameworkParts parts;
  parts.masses.assign(3, 1);
  parts.bars = {{0, 1, 1}, {1, 2, 1}};
  parts.fixed = {1, 1, 0};
  for (const OrderKind kind : all_kinds) {
    Positions x = on_axis({0, 3, 6});
    const ResolveReport report = resolve(parts, x, {.order = kind, .max_iterations = 50}, {0});
    EXPECT_FALSE(report.converged);
    EXPECT_EQ(report.reason, StopReason::max_iterations);
    EXPECT_EQ(report.iterations, 50);
    EXPECT_EQ(report.residual, 2);
    EXPECT_EQ(report.worst, "bar joint 0 - joint 1 is 3 nm long instead of 1");
    // the others are resolved all the same
    EXPECT_EQ(x, on_axis({0, 3, 4}));
    // and a whole bar between fixed joints is no matter
    x = on_axis({0, 1, 6});
    EXPECT_TRUE(resolve(parts, x, {.order = kind}, {0}).converged);
  }
}

TEST(Ordered, FixedJointsNeverMove) {
  Random random = dice(12);
  for (const OrderKind kind : all_kinds)
    for (const Weighting& weighting : weightings) {
      Structure structure = random_structure(12, is_tree_order(kind) ? 0 : 2, random);
      structure.parts.fixed.assign(12, 0);
      for (const std::size_t j : {0U, 5U, 9U}) structure.parts.fixed[j] = 1;
      structure.parts.tethers = {{0, 1, 0.05}, {5, 9, 0.05}};
      structure.parts.contacts = {{2, 5, 2}, {9, 0, 2}};
      structure.parts.volumes = {{0, 1, 2, 3, 1, infinity, 1}};
      Positions x = structure.positions;
      x[3] += random_vector(random);
      resolve(structure.parts, x, {.order = kind, .weighting = weighting, .max_iterations = 30},
              {3});
      for (const std::size_t j : {0U, 5U, 9U}) EXPECT_EQ(x[j], structure.positions[j]);
      EXPECT_NE(x[1], structure.positions[1]);
    }
}

TEST(Ordered, CoincidentJointsPartInX) {
  FrameworkParts parts;
  parts.masses.assign(2, 1);
  parts.bars = {{0, 1, 1}};
  // from the nearer end to the farther one is +x
  Positions x(2, Vec3(1, 2, 3));
  EXPECT_EQ(resolve(parts, x, {.weighting = uneven}, {0}).iterations, 1);
  EXPECT_EQ(x, (Positions{{0.75, 2, 3}, {1.75, 2, 3}}));
  x.assign(2, Vec3(1, 2, 3));
  resolve(parts, x, {.weighting = uneven}, {1});
  EXPECT_EQ(x, (Positions{{1.75, 2, 3}, {0.75, 2, 3}}));
}

TEST(Ordered, CoincidentContactsPartInX) {
  FrameworkParts parts;
  parts.masses.assign(2, 1);
  parts.contacts = {{1, 0, 1}};
  Positions x(2, Vec3(0, 5, 0));
  EXPECT_EQ(resolve(parts, x, {}).iterations, 1);
  EXPECT_EQ(x, (Positions{{0.5, 5, 0}, {-0.5, 5, 0}}));

  parts.contacts.clear();
  parts.contact_rule.radii = {0.5, 0.5};
  parts.contact_rule.polarity.assign(2, Polarity::none);
  parts.contact_rule.scale = 1;
  parts.contact_rule.exclusion_begin.assign(3, 0);
  x.assign(2, Vec3(0, 5, 0));
  EXPECT_EQ(resolve(parts, x, {}).iterations, 1);
  EXPECT_EQ(x, (Positions{{-0.5, 5, 0}, {0.5, 5, 0}}));
}

TEST(Ordered, AllJointsAtOnePlaceAreResolved) {
  Random random = dice(13);
  const Structure structure = random_structure(10, 0, random);
  Positions x(10, Vec3::Zero());
  EXPECT_EQ(resolve(structure.parts, x, {.weighting = far_only}, {4}).iterations, 1);
  EXPECT_LE(worst_of(structure.parts, x), 1e-12);
}

}  // namespace
}  // namespace ragdoll
