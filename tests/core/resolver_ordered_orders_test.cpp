// Tests for core/src/resolver_ordered.cpp: orders.

#include <gtest/gtest.h>

#include "ordered_examples.h"

namespace ragdoll {
namespace {

using namespace examples;

// === Orders that change

TEST(Ordered, RandomOrdersAreThoseOfTheirSeedAndStep) {
  Random random = dice(7);
  const Structure structure = random_structure(15, 3, random);
  Positions broken = structure.positions;
  broken[4] += random_vector(random);
  for (const OrderKind kind : {OrderKind::random, OrderKind::bfs_random}) {
    const auto run = [&](std::uint64_t seed, std::uint64_t step) {
      Positions x = broken;
      resolve(structure.parts, x, {.order = kind, .tolerance = 1e-6, .seed = seed}, {4}, step);
      return x;
    };
    EXPECT_EQ(run(1, 1), run(1, 1));
    EXPECT_NE(run(1, 1), run(1, 2));
    EXPECT_NE(run(1, 1), run(2, 1));
  }
}

TEST(Ordered, OrderOfOneForceDoesNotDependOnTheForcesBefore) {
  Random random = dice(8);
  for (const OrderKind kind : all_kinds) {
    const Structure structure = random_structure(12, is_tree_order(kind) ? 0 : 3, random);
    Positions broken = structure.positions;
    broken[4] += random_vector(random);
    const ResolverSettings settings = {.solver = "ordered", .order = kind, .max_iterations = 50};
    const auto used = make_resolver(framework_of(structure.parts), settings);
    for (const int root : {1, 7}) {
      Positions x = structure.positions;
      x[std::size_t(root)] += random_vector(random);
      used->resolve(x, {.roots = std::vector<int>{root}});
    }
    Positions x = broken, y = broken;
    const std::vector<int> roots = {4};
    const ResolveReport one = used->resolve(x, {.roots = roots, .step = 3});
    const ResolveReport two = resolve(structure.parts, y, settings, roots, 3);
    EXPECT_EQ(one.iterations, two.iterations) << name_of(kind);
    EXPECT_EQ(x, y) << name_of(kind);
  }
}

TEST(Ordered, AdaptOrderForgetsTheProblemConstraintOfTheForceBefore) {
  // a chain of seven bars that ends in a triangle; the first force breaks the triangle, the second
  // is used up along the chain, where no problem constraint is corrected
  Positions start;
  for (int j = 0; j < 9; ++j) start.emplace_back(j, 0, 0);
  start.emplace_back(7.5, 0.8, 0);
  const FrameworkParts parts = parts_of("ab bc cd de ef fg gh hi hj ij", start);
  const ResolverSettings settings = {
      .solver = "ordered", .order = OrderKind::bfs_adapt, .tolerance = 0.1};
  const auto used = make_resolver(framework_of(parts), settings);
  Positions x = start;
  x[8] += Vec3(0, -2, 0);
  x[9] += Vec3(0, 2, 0);
  ASSERT_GT(used->resolve(x, {.roots = std::vector<int>{0}}).iterations, 1);

  Positions y = start, z = start;
  y[0] = z[0] = Vec3(-1, 0, 0);
  const ResolveReport report = used->resolve(y, {.roots = std::vector<int>{0}});
  EXPECT_GT(report.iterations, 1);
  EXPECT_EQ(report.iterations, resolve(parts, z, settings, {0}).iterations);
  EXPECT_EQ(y, z);
  EXPECT_EQ(y[8], start[8]);
}

TEST(Ordered, RandomOrderIsShuffledAnewInEachIteration) {
  // two bars pull on b from either side, far share only: which one came last is whole after a pass
  FrameworkParts parts;
  parts.masses.assign(3, 1);
  parts.bars = {{0, 1, 1}, {2, 1, 1}};
  int last_was[2] = {0, 0};
  for (long passes = 1; passes <= 40; ++passes) {
    Positions x = on_axis({0, 1, 3});
    resolve(parts, x,
            {.order = OrderKind::random, .weighting = far_only, .max_iterations = passes});
    ++last_was[x[1][0] > 1.5];
  }
  EXPECT_GE(last_was[0], 8);
  EXPECT_GE(last_was[1], 8);
}

TEST(Ordered, CustomOrderReplacesTheNamedOne) {
  PulledChain chain;
  const Order order = {{1, 2, 1, false}, {0, 1, 0, false}};
  const ResolveReport report =
      resolve(chain.parts, chain.x, {.weighting = far_only, .custom_order = order}, {0});
  EXPECT_EQ(chain.x, on_axis({0, 1, 2}));
  EXPECT_EQ(report.iterations, 1);
}

TEST(Ordered, CustomOrderThatLeavesABrokenBarOutIsNotConverged) {
  PulledChain chain;
  const Order order = {{1, 1, 2, false}};
  const ResolveReport report =
      resolve(chain.parts, chain.x, {.max_iterations = 20, .custom_order = order}, {0});
  EXPECT_FALSE(report.converged);
  EXPECT_EQ(report.iterations, 20);
  EXPECT_EQ(report.bar_visits, 20);
  EXPECT_EQ(report.residual, 1);
  EXPECT_EQ(report.worst, "bar joint 0 - joint 1 is 2 nm long instead of 1");
}

TEST(Ordered, OtherComponentsAreLeftAsTheyAre) {
  Random random = dice(9);
  Structure one = random_structure(8, 1, random);
  const Structure other = random_structure(8, 1, random);
  for (Bar bar : other.parts.bars) one.parts.bars.push_back({bar.p + 8, bar.q + 8, bar.length});
  one.positions.insert(one.positions.end(), other.positions.begin(), other.positions.end());
  one.parts.masses.assign(16, 1);
  for (const OrderKind kind :
       {OrderKind::bfs_cycle, OrderKind::dfs_reverse, OrderKind::bfs_adapt}) {
    Positions x = one.positions;
    x[12] += 0.4 * random_vector(random);
    const ResolveReport report = resolve(one.parts, x, {.order = kind}, {12});
    EXPECT_TRUE(report.converged);
    EXPECT_GT(report.iterations, 0);
    for (std::size_t j = 0; j < 8; ++j) EXPECT_EQ(x[j], one.positions[j]);
  }
}

}  // namespace
}  // namespace ragdoll
