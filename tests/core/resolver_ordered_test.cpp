// Tests for core/src/resolver_ordered.cpp: steps and counts.

#include <gtest/gtest.h>

#include <algorithm>  // max
#include <cmath>      // pow

#include "naive_sweep.h"
#include "ordered_examples.h"

namespace ragdoll {
namespace {

using namespace examples;

// === Hand-computed

TEST(Ordered, EvenChainTakesTheStepsComputedByHand) {
  // pass 1: ab 2 -> a -.5, b .5; bc 1.5 -> b .75, c 1.75.  pass 2: ab 1.25 -> a -.375, b .625;
  // bc 1.125 -> b .6875, c 1.6875; now ab is 1.0625
  PulledChain chain;
  const ResolveReport report = resolve(chain.parts, chain.x, {.tolerance = 0.1}, {0});
  EXPECT_EQ(report.iterations, 2);
  EXPECT_EQ(report.bar_visits, 4);
  EXPECT_EQ(chain.x, on_axis({-0.375, 0.6875, 1.6875}));
  EXPECT_EQ(report.residual, 0.0625);
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.reason, StopReason::within_tolerance);
  EXPECT_EQ(report.worst, "");
}

TEST(Ordered, UnevenChainTakesTheStepsComputedByHand) {
  // pass 1: ab 2 -> a -.75, b .25; bc 1.75 -> b .4375, c 1.4375.  pass 2: ab 1.1875 ->
  // a -.703125, b .296875; bc 1.140625 -> b .33203125, c 1.33203125; now ab is 1.03515625
  PulledChain chain;
  const ResolveReport report =
      resolve(chain.parts, chain.x, {.weighting = uneven, .tolerance = 0.1}, {0});
  EXPECT_EQ(report.iterations, 2);
  EXPECT_EQ(chain.x, on_axis({-0.703125, 0.33203125, 1.33203125}));
}

TEST(Ordered, ReverseOrderVisitsEachBarTwiceAnIteration) {
  // pass 1: ab, bc as above, bc again is whole, ab 1.25 -> a -.375, b .625.  pass 2: bc 1.125 ->
  // b .6875, c 1.6875
  PulledChain chain;
  const ResolveReport report =
      resolve(chain.parts, chain.x, {.order = OrderKind::bfs_reverse, .tolerance = 0.1}, {0});
  EXPECT_EQ(report.iterations, 2);
  EXPECT_EQ(report.bar_visits, 8);
  EXPECT_EQ(chain.x, on_axis({-0.375, 0.6875, 1.6875}));
}

TEST(Ordered, RootDecidesWhichEndIsNearer) {
  PulledChain chain;
  Positions from_a = chain.x, from_c = chain.x;
  resolve(chain.parts, from_a, {.weighting = far_only}, {0});
  EXPECT_EQ(from_a, on_axis({-1, 0, 1}));
  resolve(chain.parts, from_c, {.weighting = far_only}, {2});
  EXPECT_EQ(from_c, on_axis({0, 1, 2}));
}

TEST(Ordered, WithoutRootsTheMiddleJointIsTheRoot) {
  const FrameworkParts parts =
      parts_of("ab bc cd de", {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}});
  Positions x = on_axis({-2, 0.5, 2, 3.5, 6});
  const ResolveReport report = resolve(parts, x, {.weighting = far_only});
  EXPECT_EQ(x, on_axis({0, 1, 2, 3, 4}));
  EXPECT_EQ(report.iterations, 1);
}

TEST(Ordered, ProblemConstraintsAreAlwaysEven) {
  // a right angle at a; c and b too far apart by 2: each gets half, whatever the weighting
  FrameworkParts parts;
  parts.masses.assign(3, 1);
  parts.bars = {{0, 1, 4}, {0, 2, 3}, {1, 2, 3}};
  const Positions start = {{0, 0, 0}, {4, 0, 0}, {0, 3, 0}};
  for (const Weighting& weighting : weightings) {
    Positions x = start;
    resolve(parts, x, {.weighting = weighting, .max_iterations = 1}, {0});
    EXPECT_NEAR((x[1] - Vec3(3.2, 0.6, 0)).norm(), 0, 1e-15);
    EXPECT_NEAR((x[2] - Vec3(0.8, 2.4, 0)).norm(), 0, 1e-15);
  }
}

TEST(Ordered, RandomOrderTakesTheFirstJointAsTheNearerEnd) {
  Positions x = on_axis({0, 3});
  FrameworkParts parts;
  parts.masses.assign(2, 1);
  parts.bars = {{1, 0, 1}};
  resolve(parts, x, {.order = OrderKind::random, .weighting = far_only}, {0});
  EXPECT_EQ(x, on_axis({2, 3}));
}

// === Counts

TEST(Ordered, NothingBrokenTakesNoIterationAndMovesNothing) {
  Random random = dice(1);
  for (const OrderKind kind : all_kinds)
    for (const Weighting& weighting : weightings) {
      const Structure structure = random_structure(12, is_tree_order(kind) ? 0 : 3, random);
      Positions x = structure.positions;
      const ResolveReport report =
          resolve(structure.parts, x, {.order = kind, .weighting = weighting}, {2});
      EXPECT_EQ(report.iterations, 0);
      EXPECT_EQ(report.bar_visits, 0);
      EXPECT_TRUE(report.converged);
      EXPECT_EQ(report.reason, StopReason::nothing_broken);
      EXPECT_EQ(x, structure.positions);
    }
}

TEST(Ordered, TreesWithTheFarShareOnlyTakeExactlyOneIteration) {
  const double tolerance = 1e-5;
  Random random = dice(2);
  for (const OrderKind kind : {OrderKind::bfs_tree, OrderKind::dfs_tree, OrderKind::bfs_cycle,
                               OrderKind::dfs_cycle, OrderKind::bfs_adapt, OrderKind::bfs_random})
    for (int tree = 0; tree < 10; ++tree) {
      const Structure structure = random_structure(3 + 3 * tree, 0, random);
      const int joints = int(structure.positions.size());
      Positions x = structure.positions;
      const auto resolver = make_resolver(
          framework_of(structure.parts),
          {.solver = "ordered", .order = kind, .weighting = far_only, .tolerance = tolerance});
      int broken = 0;
      for (int force = 0; force < 50; ++force) {
        // forces of all sizes; the next one starts where the last one left the joints
        const std::vector<int> roots = {int(random.below(std::uint64_t(joints)))};
        x[std::size_t(roots[0])] += std::pow(10, force % 5 - 1) * random_vector(random);
        const bool breaks = worst_of(structure.parts, x) > tolerance;
        const ResolveReport report = resolver->resolve(x, {.roots = roots});
        EXPECT_EQ(report.iterations, breaks ? 1 : 0);
        EXPECT_EQ(report.bar_visits, breaks ? joints - 1 : 0);
        EXPECT_LE(worst_of(structure.parts, x), tolerance);
        broken += breaks;
      }
      EXPECT_GT(broken, 45);
    }
}

TEST(Ordered, TreesAreResolvedInOneIterationEvenWhenEveryJointMoved) {
  Random random = dice(3);
  for (int tree = 0; tree < 20; ++tree) {
    const Structure structure = random_structure(20, 0, random);
    Positions x = structure.positions;
    for (Vec3& point : x) point += random_vector(random);
    EXPECT_EQ(resolve(structure.parts, x, {.weighting = far_only}).iterations, 1);
  }
}

TEST(Ordered, ToleranceIsRelativeToTheLength) {
  FrameworkParts parts;
  parts.masses.assign(2, 1);
  const auto iterations = [&](double length, double distance) {
    parts.bars = {{0, 1, length}};
    Positions x = on_axis({0, distance});
    return resolve(parts, x, {.tolerance = 0.01}).iterations;
  };
  EXPECT_EQ(iterations(100, 100.9), 0);
  EXPECT_EQ(iterations(100, 101.1), 1);
  EXPECT_EQ(iterations(0.1, 0.0991), 0);
  EXPECT_EQ(iterations(0.1, 0.0989), 1);
}

TEST(Ordered, ResolveIsIdempotent) {
  Random random = dice(4);
  for (const OrderKind kind : all_kinds)
    for (const Weighting& weighting : {even, uneven}) {
      const Structure structure = random_structure(12, is_tree_order(kind) ? 0 : 2, random);
      Positions x = structure.positions;
      x[5] += 0.5 * random_vector(random);
      const ResolverSettings settings = {.order = kind, .weighting = weighting};
      ASSERT_TRUE(resolve(structure.parts, x, settings, {5}).converged) << name_of(kind);
      const Positions resolved = x;
      const ResolveReport again = resolve(structure.parts, x, settings, {5}, 1);
      EXPECT_EQ(again.iterations, 0);
      EXPECT_EQ(again.reason, StopReason::nothing_broken);
      EXPECT_EQ(x, resolved);
    }
}

TEST(Ordered, LabelsOfTheJointsDoNotMatter) {
  Random random = dice(5);
  for (const OrderKind kind : all_kinds)
    for (int round = 0; round < 6; ++round) {
      const Structure structure = random_structure(12, is_tree_order(kind) ? 0 : 2, random);
      Positions x = structure.positions;
      x[3] += random_vector(random);
      // joint j becomes label[j]; bars keep their order and direction
      const std::vector<std::size_t> label = {7, 2, 9, 0, 11, 5, 1, 3, 10, 8, 4, 6};
      FrameworkParts other = structure.parts;
      for (Bar& bar : other.bars) {
        bar.p = int(label[std::size_t(bar.p)]);
        bar.q = int(label[std::size_t(bar.q)]);
      }
      Positions y(12);
      for (std::size_t j = 0; j < 12; ++j) y[label[j]] = x[j];
      // a random root is a label: no such iteration here
      const long maximum = kind == OrderKind::bfs_random ? 1 : 200;
      const ResolverSettings settings = {.order = kind, .max_iterations = maximum, .seed = 8};
      const ResolveReport one = resolve(structure.parts, x, settings, {3});
      const ResolveReport two = resolve(other, y, settings, {0});
      EXPECT_EQ(one.iterations, two.iterations) << name_of(kind);
      EXPECT_GT(one.iterations, 0);
      for (std::size_t j = 0; j < 12; ++j) EXPECT_EQ(y[label[j]], x[j]);
    }
}

// === Against plain loops

TEST(Ordered, CountsAndPositionsAreThoseOfPlainLoops) {
  Random random = dice(6);
  long compared = 0, unresolved = 0;
  for (const int cycles : {0, 1, 2, 5})
    for (int round = 0; round < 40; ++round)
      for (const OrderKind kind : all_kinds) {
        if (kind == OrderKind::random || kind == OrderKind::bfs_random) continue;
        if (is_tree_order(kind) && cycles > 0) continue;
        for (const Weighting& weighting : weightings) {
          const Structure structure = random_structure(6 + round % 12, cycles, random);
          const int root = int(random.below(std::uint64_t(6 + round % 12)));
          Positions x = structure.positions;
          x[std::size_t(root)] += random_vector(random);
          NaiveSweep naive(structure, x);
          naive.weighting = weighting;
          naive.tol = round % 2 == 0 ? 1e-3 : 1e-5;
          naive.max_iterations = round % 4 == 0 ? 4 : 300;
          const NaiveSweep::Count count = naive.run(kind, root);
          const ResolveReport report = resolve(structure.parts, x,
                                               {.order = kind,
                                                .weighting = weighting,
                                                .tolerance = naive.tol,
                                                .max_iterations = naive.max_iterations},
                                               {root});
          EXPECT_EQ(report.iterations, count.iterations) << name_of(kind);
          EXPECT_EQ(report.bar_visits, count.visits) << name_of(kind);
          EXPECT_EQ(report.converged, count.converged) << name_of(kind);
          double apart = 0;
          for (std::size_t j = 0; j < x.size(); ++j)
            apart = std::max(apart, (x[j] - Vec3(naive.x[j], naive.y[j], naive.z[j])).norm());
          EXPECT_LE(apart, 1e-9) << name_of(kind) << ", " << name_of(weighting);
          ++compared;
          unresolved += !count.converged;
        }
      }
  EXPECT_EQ(compared, 40 * (7 + 3 * 5) * 3);
  // both outcomes were seen
  EXPECT_GT(unresolved, 100);
  EXPECT_LT(unresolved, compared / 2);
}

}  // namespace
}  // namespace ragdoll
