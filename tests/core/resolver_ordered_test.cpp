// Tests for core/src/resolver_ordered.cpp.

#include <gtest/gtest.h>

#include <algorithm>  // max
#include <cmath>      // sqrt, abs, pow
#include <limits>

#include "examples.h"
#include "naive_sweep.h"
#include "ragdoll/resolver.h"  // make_resolver

namespace ragdoll {
namespace {

using namespace examples;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

const Weighting even = {0.5, 0.5}, uneven = {0.25, 0.75}, far_only = {0, 1};
const Weighting weightings[] = {even, uneven, far_only};

constexpr OrderKind all_kinds[] = {
    OrderKind::random,      OrderKind::bfs_tree,  OrderKind::dfs_tree,
    OrderKind::bfs_cycle,   OrderKind::dfs_cycle, OrderKind::bfs_reverse,
    OrderKind::dfs_reverse, OrderKind::bfs_adapt, OrderKind::bfs_random};

bool is_tree_order(OrderKind kind) {
  return kind == OrderKind::bfs_tree || kind == OrderKind::dfs_tree;
}

Random dice(std::uint64_t seed) {
  return Random(seed, RandomStream::generate, 0);
}

ResolveReport resolve(const FrameworkParts& parts, Positions& x, ResolverSettings settings,
                      const std::vector<int>& roots = {}, std::uint64_t step = 0) {
  settings.solver = "ordered";
  return make_resolver(framework_of(parts), settings)->resolve(x, {.roots = roots, .step = step});
}

double worst_of(const FrameworkParts& parts, const Positions& x) {
  double worst = 0;
  for (const Bar& bar : parts.bars) {
    const double d = (x[std::size_t(bar.q)] - x[std::size_t(bar.p)]).norm();
    worst = std::max(worst, std::abs(d - bar.length) / bar.length);
  }
  return worst;
}

/// Three joints on a line, bars of length 1, and joint a pulled away by 1.
struct PulledChain {
  FrameworkParts parts = parts_of("ab bc", {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}});
  Positions x = {{-1, 0, 0}, {1, 0, 0}, {2, 0, 0}};
};

/// Positions on the x axis.
Positions on_axis(std::initializer_list<double> values) {
  Positions x;
  for (const double value : values) x.emplace_back(value, 0, 0);
  return x;
}

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

}  // namespace
}  // namespace ragdoll
