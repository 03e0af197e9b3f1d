// Tests for core/src/resolver_block.cpp: what it resolves, and what it leaves alone.

#include <gtest/gtest.h>

#include <algorithm>  // find
#include <utility>    // exchange

#include "block_examples.h"

namespace ragdoll {
namespace {

using namespace block_examples;
using examples::random_vector;

// === One iteration

struct Case {
  StructureRequest request;
  double lo, hi, tolerance;
};

/// Failures among the forces on some structures; half of these start from rest, the others go on.
int failures(const Case& c, int structures, int forces) {
  int failed = 0;
  for (int s = 0; s < structures; ++s) {
    StructureRequest request = c.request;
    request.index = std::uint64_t(s);
    const Structure structure = generate_structure(request);
    const ForceSet set = generate_forces(
        structure, {.count = forces, .lo = c.lo, .hi = c.hi, .index = std::uint64_t(s)});
    const auto resolver =
        make_resolver(framework_of(structure), {.solver = "block", .tolerance = c.tolerance});
    Positions x = structure.positions;
    for (const Force& force : set.forces) {
      if (s % 2 == 0) x = structure.positions;
      const auto root = std::size_t(force.joint);
      x[root] += force.force / structure.parts.masses[root];
      const Vec3 forced = x[root];
      const ResolveReport report = resolver->resolve(x, {.roots = {&force.joint, 1}});
      const double worst = worst_of(structure.parts.bars, x);
      EXPECT_EQ(x[root], forced);
      EXPECT_LE(report.iterations, 1);
      EXPECT_NEAR(report.residual, worst, 1e-12);
      EXPECT_EQ(report.converged, worst <= c.tolerance);
      EXPECT_EQ(report.converged, report.worst.empty());
      if (report.converged) continue;
      ++failed;
      x = structure.positions;
    }
  }
  return failed;
}

TEST(Block, OneIterationResolvesEveryClassForMovesOfUpToTwoBarLengths) {
  for (const StructureRequest& request : classes)
    for (const double tolerance : {1e-2, 1e-6})
      EXPECT_EQ(failures({request, 0.1, 2, tolerance}, 10, 50), 0)
          << request.class_name << " " << request.type << " " << tolerance;
}

TEST(Block, OneIterationResolvesEveryMoveOfUpToTwentyBarLengths) {
  int failed = 0;
  for (const StructureRequest& request : classes)
    for (const double tolerance : {1e-2, 1e-6})
      failed += failures({request, 2, 20, tolerance}, 10, 50);
  EXPECT_EQ(failed, 0);
}

TEST(Block, BreakOfAllJointsIsResolvedInOneIteration) {
  Random random(3, RandomStream::generate, 0);
  for (const StructureRequest& request : classes) {
    const Structure structure = generate_structure(request);
    const auto resolver =
        make_resolver(framework_of(structure), {.solver = "block", .tolerance = 1e-6});
    Positions x = structure.positions;
    for (int step = 0; step < 20; ++step) {
      for (Vec3& point : x) point += 0.2 * random_vector(random);
      const ResolveReport report = resolver->resolve(x, {});
      EXPECT_TRUE(report.converged) << request.class_name << " " << report.worst;
      EXPECT_EQ(report.iterations, 1);
      EXPECT_LE(worst_of(structure.parts.bars, x), 1e-6);
    }
  }
}

TEST(Block, LargeCycleBlocksAreResolved) {
  const Structure structure =
      generate_structure({.class_name = "grid", .joints = 900, .dimensions = 2});
  const auto resolver =
      make_resolver(framework_of(structure), {.solver = "block", .tolerance = 1e-6});
  Positions x = structure.positions;
  const int root = 431;
  x[431] += Vec3(0.5, 0.2, 1);
  const ResolveReport report = resolver->resolve(x, {.roots = {&root, 1}});
  EXPECT_TRUE(report.converged) << report.worst;
  EXPECT_EQ(report.iterations, 1);
  EXPECT_LE(worst_of(structure.parts.bars, x), 1e-6);
}

TEST(Block, TightTolerancesAreMet) {
  for (const StructureRequest& request : classes)
    EXPECT_EQ(failures({request, 0.1, 2, 1e-12}, 2, 20), 0) << request.class_name;
}

TEST(Block, NothingBrokenIsNoIteration) {
  const Structure structure = generate_structure(classes[5]);
  Positions x = structure.positions;
  const auto resolver = make_resolver(framework_of(structure), {.solver = "block"});
  for (int k = 0; k < 2; ++k) {
    const ResolveReport report = resolver->resolve(x, {});
    EXPECT_TRUE(report.converged);
    EXPECT_EQ(report.iterations, 0);
    EXPECT_EQ(report.bar_visits, 0);
    EXPECT_EQ(report.reason, StopReason::nothing_broken);
    EXPECT_EQ(x, structure.positions);
  }
}

TEST(Block, SameBreakGivesTheSameResult) {
  const Structure structure = generate_structure(classes[8]);
  const std::vector<int> root = {4};
  Positions x = structure.positions;
  x[4] += Vec3(3, 5, 1);
  Positions y = x;
  resolve(structure.parts, x, root);
  resolve(structure.parts, y, root);
  EXPECT_EQ(x, y);
}

// === Untouched parts

TEST(Block, WhatIsNotTouchedDoesNotMove) {
  // a triangle, a bridge, a triangle: cd is long enough for what happens at a
  const Positions rest = {{0, 0, 0}, {0, 1, 0}, {1, 0.5, 0}, {2, 0.5, 0}, {3, 0, 0}, {3, 1, 0}};
  const FrameworkParts parts = parts_of("ab bc ca cd de ef fd", rest);
  Positions x = rest;
  x[4] += Vec3(0, 0, 1e-9);
  const std::vector<int> root = {4};
  // within tolerance: all stays, the root too
  Positions moved = x;
  EXPECT_EQ(resolve(parts, x, root).iterations, 0);
  EXPECT_EQ(x, moved);

  // a far triangle's turn about d leaves d and all before it
  const auto resolver = block(parts);
  x = rest;
  resolver->resolve(x, {});
  x[3] += Vec3(0, 0, 0.3);
  const ResolveReport report = resolver->resolve(x, {.roots = std::vector<int>{3}});
  EXPECT_TRUE(report.converged);
  EXPECT_NE(x[2], rest[2]);

  const Structure chain = caterpillar(1000);
  const auto worker = block(chain.parts, 1e-2);
  Positions y = chain.positions;
  worker->resolve(y, {});
  y[1000] += Vec3(0.4, 0.3, 0.9);
  worker->resolve(y, {.roots = std::vector<int>{1000}});
  int different = 0;
  for (std::size_t j = 0; j < y.size(); ++j) different += y[j] != chain.positions[j];
  EXPECT_GT(different, 2);
  EXPECT_LT(different, 60);
  EXPECT_EQ(y[0], chain.positions[0]);
  EXPECT_EQ(y[1999], chain.positions[1999]);
}

TEST(Block, VisitsForOneForcedJointDoNotGrowWithTheStructure) {
  for (const int spine : {500, 5000, 50000}) {
    const Structure chain = caterpillar(spine);
    const auto resolver = block(chain.parts, 1e-2);
    Positions x = chain.positions;
    resolver->resolve(x, {});
    const ForceSet forces = generate_forces(chain, {.count = 300});
    std::int64_t visits = 0;
    for (const Force& force : forces.forces) {
      x[std::size_t(force.joint)] += force.force;
      const ResolveReport report = resolver->resolve(x, {.roots = {&force.joint, 1}});
      ASSERT_TRUE(report.converged);
      ASSERT_LE(report.iterations, 1);
      visits += report.bar_visits;
    }
    EXPECT_LE(double(visits) / 300, 40) << spine;
    EXPECT_LE(worst_of(chain.parts.bars, x), 1e-2);
  }
}

TEST(Block, WorkListGivesWhatTheWholeSweepGives) {
  for (const StructureRequest& request : classes) {
    const Structure structure = generate_structure(request);
    const ForceSet set = generate_forces(structure, {.count = 40});
    const auto known = make_resolver(framework_of(structure), {.solver = "block"});
    Positions x = structure.positions;
    known->resolve(x, {});
    for (const Force& force : set.forces) {
      x[std::size_t(force.joint)] += force.force;
      Positions y = x;
      known->resolve(x, {.roots = {&force.joint, 1}});
      make_resolver(framework_of(structure), {.solver = "block"})
          ->resolve(y, {.roots = {&force.joint, 1}});
      EXPECT_EQ(x, y) << request.class_name;
    }
  }
}

TEST(Block, PromiseThatOnlyRootsMovedChangesNothing) {
  for (const StructureRequest& request : classes) {
    const Structure structure = generate_structure(request);
    const ForceSet set = generate_forces(structure, {.count = 60, .hi = 4});
    const auto told = make_resolver(framework_of(structure), {.solver = "block"});
    const auto looks = make_resolver(framework_of(structure), {.solver = "block"});
    Positions x = structure.positions, y = x;
    bool first = true;
    for (const Force& force : set.forces) {
      x[std::size_t(force.joint)] += force.force;
      y = x;
      const ResolveReport a = told->resolve(
          x, {.roots = {&force.joint, 1}, .only_roots_moved = !std::exchange(first, false)});
      const ResolveReport b = looks->resolve(y, {.roots = {&force.joint, 1}});
      EXPECT_EQ(x, y) << request.class_name;
      EXPECT_EQ(a.bar_visits, b.bar_visits);
      EXPECT_EQ(a.residual, b.residual);
      EXPECT_EQ(a.residual_nm, b.residual_nm);
      EXPECT_NEAR(a.residual, worst_of(structure.parts.bars, x), 1e-12);
    }
  }
}

TEST(Block, JointsThatMovedAreTold) {
  const Structure chain = caterpillar(300);
  const auto resolver = block(chain.parts, 1e-2);
  Positions x = chain.positions;
  resolver->resolve(x, {});
  EXPECT_EQ(resolver->moved_joints(), nullptr);  // the first time it could be any
  for (const int root : {0, 301, 599}) {
    const Positions before = x;
    x[std::size_t(root)] += Vec3(0.4, 0.3, 0.9);
    resolver->resolve(x, {.roots = {&root, 1}, .only_roots_moved = true});
    ASSERT_NE(resolver->moved_joints(), nullptr);
    const std::vector<int>& moved = *resolver->moved_joints();
    EXPECT_LT(moved.size(), 100U);
    for (int j = 0; j < int(x.size()); ++j) {
      const bool told = std::find(moved.begin(), moved.end(), j) != moved.end();
      EXPECT_TRUE(told || x[std::size_t(j)] == before[std::size_t(j)]) << j;
    }
  }
}

TEST(Block, RingThatTurnsOftenIsWhatTheReportSays) {
  // it is looked at anew before what rounding adds could be noticed
  const Positions rest = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0.2}, {1, 1, 0}};
  const FrameworkParts parts = parts_of("ab bc cd de eb", rest);
  constexpr double tolerance = 1e-11;
  const auto resolver = block(parts, tolerance);
  Positions x = rest;
  resolver->resolve(x, {});
  const int root = 0;
  Random random(1, RandomStream::generate, 0);
  std::int64_t most_visits = 0;
  for (int k = 0; k < 2000; ++k) {
    x[0] = 3 * Vec3(random.uniform(), random.uniform(), random.uniform());
    const ResolveReport report =
        resolver->resolve(x, {.roots = {&root, 1}, .only_roots_moved = true});
    ASSERT_TRUE(report.converged);
    ASSERT_NEAR(report.residual, worst_of(parts.bars, x), 2e-3 * tolerance);
    most_visits = std::max(most_visits, report.bar_visits);
  }
  EXPECT_GT(most_visits, 1 + 2);
}

TEST(Block, SmallRingReachedFromOutsideKeepsItsShape) {
  // a square hangs on a joint by a bar
  const Positions rest = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0.2}, {1, 1, 0}};
  const FrameworkParts parts = parts_of("ab bc cd de eb", rest);
  const auto resolver = block(parts, 1e-9);
  Positions x = rest;
  resolver->resolve(x, {});
  const std::vector<int> root = {0};
  x[0] += Vec3(-0.7, 0.4, 0.3);
  const ResolveReport report = resolver->resolve(x, {.roots = root});
  EXPECT_TRUE(report.converged);
  // the bridge, and the bars of the square's entry joint
  EXPECT_EQ(report.bar_visits, 1 + 2);
  const auto distance = [](const Positions& at, std::size_t p, std::size_t q) {
    return (at[q] - at[p]).norm();
  };
  for (std::size_t p = 1; p < 5; ++p)
    for (std::size_t q = 1; q < p; ++q) EXPECT_NEAR(distance(x, p, q), distance(rest, p, q), 1e-9);
  EXPECT_NE(x[3], rest[3]);

  // a force on the square itself deforms it
  x = rest;
  resolver->resolve(x, {});
  x[3] += Vec3(0.3, 0.5, 0.6);
  EXPECT_TRUE(resolver->resolve(x, {.roots = std::vector<int>{3}}).converged);
  EXPECT_GT(std::abs(distance(x, 1, 3) - distance(rest, 1, 3)), 1e-3);
}

TEST(Block, JointsThatTheCallerMovedBesidesTheRootsAreSeen) {
  const Structure chain = caterpillar(100);
  const auto resolver = block(chain.parts);
  Positions x = chain.positions;
  resolver->resolve(x, {});
  x[10] += Vec3(0, 0.5, 0.5);
  x[150] += Vec3(0, 0, 1);
  const ResolveReport report = resolver->resolve(x, {.roots = std::vector<int>{10}});
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.iterations, 1);
  EXPECT_LE(worst_of(chain.parts.bars, x), 1e-6);
  EXPECT_NEAR(report.residual, worst_of(chain.parts.bars, x), 1e-12);
}

TEST(Block, FirstOfSeveralRootsKeepsItsPlaceAndOtherComponentsAreResolvedFromTheirs) {
  const Positions rest = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 5, 0}, {1, 5, 0}, {2, 5, 0}};
  const FrameworkParts parts = parts_of("ab bc de ef", rest);
  const auto resolver = block(parts);
  Positions x = rest;
  resolver->resolve(x, {});
  const std::vector<int> roots = {2, 0, 4};
  for (const int root : roots) x[std::size_t(root)] += Vec3(0.5, 0.5, 0.5);
  const Positions forced = x;
  const ResolveReport report = resolver->resolve(x, {.roots = roots});
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.iterations, 1);
  EXPECT_EQ(x[2], forced[2]);
  EXPECT_EQ(x[4], forced[4]);
  EXPECT_NE(x[0], forced[0]);
  EXPECT_LE(worst_of(parts.bars, x), 1e-12);
}

}  // namespace
}  // namespace ragdoll
