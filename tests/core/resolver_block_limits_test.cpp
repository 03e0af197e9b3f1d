// Tests for core/src/resolver_block.cpp: fixed and coincident joints, and what cannot be resolved.

#include <gtest/gtest.h>

#include <cmath>  // isfinite
#include <limits>

#include "block_examples.h"

namespace ragdoll {
namespace {

using namespace block_examples;
using examples::refusal_of;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

// === Fixed and coincident joints

TEST(Block, FixedJointsNeverMoveAndTheRestGivesWay) {
  for (const StructureRequest& request : classes) {
    Structure structure = generate_structure(request);
    structure.parts.fixed.assign(structure.positions.size(), 0);
    for (const std::size_t j : {0U, 7U, 11U}) structure.parts.fixed[j] = 1;
    const ForceSet set = generate_forces(structure, {.count = 40});
    const auto resolver =
        make_resolver(framework_of(structure), {.solver = "block", .tolerance = 1e-6});
    Positions x = structure.positions;
    for (const Force& force : set.forces) {
      x[std::size_t(force.joint)] += force.force;
      const ResolveReport report = resolver->resolve(x, {.roots = {&force.joint, 1}});
      const double worst = worst_of(structure.parts.bars, x);
      EXPECT_EQ(report.converged, worst <= 1e-6);
      EXPECT_TRUE(report.converged) << request.class_name << " " << report.worst;
      EXPECT_LE(report.iterations, 2);
      for (const std::size_t j : {0U, 7U, 11U}) EXPECT_EQ(x[j], structure.positions[j]);
      if (!report.converged) x = structure.positions;
    }
  }
}

TEST(Block, ForcedJointGivesWayToAFixedOneInASecondSweep) {
  FrameworkParts parts;
  parts.masses.assign(2, 1);
  parts.bars = {{0, 1, 1}};
  parts.fixed = {1, 0};
  Positions x = {{0, 0, 0}, {3, 0, 0}};
  const ResolveReport report = resolve(parts, x, {1});
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.iterations, 2);
  EXPECT_EQ(x, (Positions{{0, 0, 0}, {1, 0, 0}}));
  x = {{0, 0, 0}, {3, 0, 0}};
  const ResolveReport once = block(parts, 1e-6, 1)->resolve(x, {.roots = std::vector<int>{1}});
  EXPECT_FALSE(once.converged);
  EXPECT_EQ(once.reason, StopReason::max_iterations);
  EXPECT_EQ(once.iterations, 1);
}

TEST(Block, BarBetweenFixedJointsIsReportedAndTheRestResolved) {
  FrameworkParts parts;
  parts.masses.assign(3, 1);
  parts.bars = {{0, 1, 1}, {1, 2, 1}};
  parts.fixed = {1, 1, 0};
  Positions x = {{0, 0, 0}, {3, 0, 0}, {6, 0, 0}};
  const ResolveReport report = resolve(parts, x, {0});
  EXPECT_FALSE(report.converged);
  EXPECT_EQ(report.reason, StopReason::stagnated);
  EXPECT_EQ(report.residual, 2);
  EXPECT_EQ(report.worst, "bar joint 0 - joint 1 is 3 nm long instead of 1");
  EXPECT_EQ(x, (Positions{{0, 0, 0}, {3, 0, 0}, {4, 0, 0}}));
}

TEST(Block, CoincidentJointsAreResolved) {
  for (const StructureRequest& request : classes) {
    const Structure structure = generate_structure(request);
    Positions x(structure.positions.size(), Vec3(1, 2, 3));
    const ResolveReport report = resolve(structure.parts, x, {4});
    EXPECT_EQ(report.converged, worst_of(structure.parts.bars, x) <= 1e-6);
    EXPECT_TRUE(report.converged) << request.class_name << " " << report.worst;
  }
}

// === Not resolved

TEST(Block, ContradictoryBarsAreReportedWithTheWorst) {
  FrameworkParts triangle;
  triangle.masses.assign(3, 1);
  triangle.bars = {{0, 1, 1}, {1, 2, 1}, {2, 0, 5}};
  Positions x = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}};
  ResolveReport report = resolve(triangle, x);
  EXPECT_FALSE(report.converged);
  EXPECT_EQ(report.reason, StopReason::stagnated);
  EXPECT_EQ(report.iterations, 1);
  EXPECT_EQ(report.worst.substr(0, 4), "bar ");
  EXPECT_GT(report.residual, 0.1);
  for (const Vec3& point : x) EXPECT_TRUE(point.allFinite());

  // five joints at equal distances do not exist in space
  FrameworkParts k5;
  k5.masses.assign(5, 1);
  for (int p = 0; p < 5; ++p)
    for (int q = 0; q < p; ++q) k5.bars.push_back({p, q, 1});
  Random random(1, RandomStream::generate, 0);
  x = examples::random_points(5, 1, random);
  report = resolve(k5, x, {2});
  EXPECT_FALSE(report.converged);
  EXPECT_EQ(report.worst.substr(0, 4), "bar ");
  EXPECT_LT(report.residual, 0.5);
  for (const Vec3& point : x) EXPECT_TRUE(point.allFinite());
}

TEST(Block, AfterAFailureTheNextBreakIsResolved) {
  const Structure structure = generate_structure(classes[1]);
  const auto resolver = make_resolver(framework_of(structure), {.solver = "block"});
  for (const double bad : {nan, infinity, 1e160, 1e300, -1e308}) {
    Positions x = structure.positions;
    x[3][1] = bad;
    const Positions before = x;
    const ResolveReport report = resolver->resolve(x, {.roots = std::vector<int>{3}});
    EXPECT_FALSE(report.converged);
    EXPECT_EQ(report.reason, StopReason::not_finite);
    EXPECT_NE(report.worst, "");
    EXPECT_LE(report.iterations, std::isfinite(bad) ? 1 : 0);
    Positions y = structure.positions;
    y[5] += Vec3(1, 0, 0);
    EXPECT_TRUE(resolver->resolve(y, {.roots = std::vector<int>{5}}).converged);
    EXPECT_LE(worst_of(structure.parts.bars, y), 1e-3);
  }
}

TEST(Block, ForcesOfAMillionAreResolvedOrReported) {
  for (const StructureRequest& request : classes) {
    const Structure structure = generate_structure(request);
    Positions x = structure.positions;
    x[6] += Vec3(1e6, -2e6, 5e5);
    const ResolveReport report = resolve(structure.parts, x, {6}, 1e-3);
    EXPECT_EQ(report.converged, worst_of(structure.parts.bars, x) <= 1e-3);
    EXPECT_TRUE(report.converged);
    EXPECT_EQ(report.iterations, 1);
  }
}

// === Constraints that are no bars

/// A chain along x, of bars of length 1.
FrameworkParts chain_of(int joints) {
  FrameworkParts parts;
  parts.masses.assign(std::size_t(joints), 1);
  for (int j = 1; j < joints; ++j) parts.bars.push_back({j - 1, j, 1});
  return parts;
}

Positions straight(int joints) {
  Positions x;
  for (int j = 0; j < joints; ++j) x.emplace_back(0.9 * j, 0.43 * (j % 2), 0.1 * (j % 3));
  return x;
}

TEST(Block, TethersContactsAndVolumesAreHeldToo) {
  FrameworkParts parts = chain_of(8);
  parts.tethers = {{0, 7, 5}};
  parts.contacts = {{1, 6, 3}};
  parts.volumes = {{2, 3, 4, 5, 0.05, infinity, 1}};
  for (const std::vector<int>& roots : {std::vector<int>{}, {0}, {4}})
    for (const Tolerance& tolerance : {Tolerance(1e-4), Tolerance(1e-6)}) {
      const auto framework = examples::framework_of(parts);
      const auto resolver = make_resolver(framework, {.solver = "block", .tolerance = tolerance});
      Positions x = straight(8);
      x[0] += Vec3(-2, 1, 0.5);
      for (int step = 0; step < 5; ++step) {
        const ResolveReport report = resolver->resolve(x, {.roots = roots});
        EXPECT_TRUE(report.converged) << report.worst;
        const Violation worst = worst_violation(*framework, x, nullptr, tolerance);
        EXPECT_LE(tolerance.absolute() ? worst.nanometers : worst.relative, tolerance.value());
        EXPECT_NEAR(report.residual, worst.relative, 1e-12);
        x[4] += Vec3(0.3, -0.4, 0.2);
      }
    }
}

TEST(Block, IterationsOnOtherConstraintsAreCountedAndBounded) {
  FrameworkParts parts = chain_of(6);
  parts.tethers = {{0, 5, 1.5}};
  for (const long most : {1L, 2L, 3L, 100L}) {
    Positions x = straight(6);
    x[5] += Vec3(3, 0, 1);
    const ResolveReport report =
        block(parts, 1e-9, most)->resolve(x, {.roots = std::vector<int>{5}});
    EXPECT_LE(report.iterations, most);
    EXPECT_EQ(report.converged, most == 100);
    if (report.converged)
      EXPECT_GT(report.iterations, 1);
    else
      EXPECT_EQ(report.reason, StopReason::max_iterations);
  }
}

TEST(Block, ContradictionOfATetherAndABarIsReported) {
  FrameworkParts parts = chain_of(4);
  parts.tethers = {{1, 2, 0.4}};
  Positions x = straight(4);
  const ResolveReport report = block(parts, 1e-6)->resolve(x, {.roots = std::vector<int>{0}});
  EXPECT_FALSE(report.converged);
  EXPECT_NE(report.worst, "");
  for (const Vec3& point : x) EXPECT_TRUE(point.allFinite());
}

// === Tolerances in nm, and numbers too coarse for a tolerance

TEST(Block, AbsoluteTolerancesHoldForEveryLength) {
  for (const StructureRequest& request : classes) {
    const Structure structure = generate_structure(request);
    const auto framework = framework_of(structure);
    for (const double length : {1e-2, 1e-7}) {
      const auto resolver =
          make_resolver(framework, {.solver = "block", .tolerance = Tolerance::nanometers(length)});
      Positions x = structure.positions;
      for (const Force& force : generate_forces(structure, {.count = 20}).forces) {
        x[std::size_t(force.joint)] += force.force;
        const ResolveReport report = resolver->resolve(x, {.roots = {&force.joint, 1}});
        EXPECT_TRUE(report.converged) << report.worst;
        double worst = 0;
        for (const Bar& bar : framework->bars())
          worst = std::max(
              worst, std::abs((x[std::size_t(bar.q)] - x[std::size_t(bar.p)]).norm() - bar.length));
        EXPECT_LE(worst, length);
        EXPECT_NEAR(report.residual_nm, worst, 1e-13);
        EXPECT_NEAR(report.residual, worst_of(framework->bars(), x), 1e-12);
      }
    }
  }
}

TEST(Block, BarThatRoundingKeepsBrokenIsReported) {
  FrameworkParts parts = chain_of(3);
  const Vec3 far(1e9, 1e9, 1e9);
  Positions x = {far, far + Vec3(1.3, 0.7, 0.3), far + Vec3(2, 0.2, 0.1)};
  const ResolveReport report = block(parts, 1e-12)->resolve(x, {});
  EXPECT_FALSE(report.converged);
  EXPECT_EQ(report.reason, StopReason::stagnated);
  EXPECT_GT(worst_of(parts.bars, x), 1e-12);
}

TEST(Block, UnknownRootIsRefused) {
  const Structure structure = caterpillar(3);
  Positions x = structure.positions;
  for (const int root : {-1, 6})
    EXPECT_NE(refusal_of([&] { block(structure.parts)->resolve(x, {.roots = {&root, 1}}); }), "");
}

// === Carried

/// A triangle and a bar to it, with all joints in a line once the triangle's tip is pushed onto its
/// side: nothing within the line, and Newton stays in it, makes the triangle whole.
struct FlattenedTriangle {
  Positions rest = {{0, 0, 0}, {2, 0, 0}, {1, 1.5, 0}, {3, 0, 0}};
  FrameworkParts parts = parts_of("ab bc ca bd", rest);
  Positions broken = rest;
  FlattenedTriangle() { broken[2] = {1, 0, 0}; }
};

TEST(Block, BlockThatNoDeformationResolvesIsCarriedWholeAndTold) {
  FlattenedTriangle triangle;
  Positions x = triangle.broken;
  const ResolveReport report = resolve(triangle.parts, x, {2});
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.carried, 1);
  EXPECT_EQ(report.iterations, 1);
  EXPECT_LE(worst_of(triangle.parts.bars, x), 1e-6);
  // the joint that was pushed stays there, and the others come along in the shape that they had
  EXPECT_EQ(x[2], triangle.broken[2]);
  const Vec3 by = triangle.broken[2] - triangle.rest[2];
  for (const std::size_t j : {0U, 1U}) EXPECT_LE((x[j] - triangle.rest[j] - by).norm(), 1e-6);
}

TEST(Block, BlockThatDeformsIsNotToldAsCarried) {
  FlattenedTriangle triangle;
  Positions x = triangle.rest;
  x[2] += Vec3(0.1, 0.2, 0.3);
  const ResolveReport report = resolve(triangle.parts, x, {2});
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.carried, 0);
}

TEST(Block, CarriedBlocksOfAllComponentsAreCounted) {
  // two triangles that nothing joins, both flattened
  const Positions rest = {{0, 0, 0}, {2, 0, 0}, {1, 1.5, 0}, {0, 0, 9}, {2, 0, 9}, {1, 1.5, 9}};
  const FrameworkParts parts = parts_of("ab bc ca de ef fd", rest);
  Positions x = rest;
  x[2] = {1, 0, 0};
  x[5] = {1, 0, 9};
  const auto solver = block(parts);
  const std::vector<int> roots = {2, 5};
  EXPECT_EQ(solver->resolve(x, {.roots = roots}).carried, 2);
  EXPECT_LE(worst_of(parts.bars, x), 1e-6);
  // the next break is told for itself
  x[2] += Vec3(0.1, 0.2, 0.3);
  EXPECT_EQ(solver->resolve(x, {.roots = {roots.data(), 1}}).carried, 0);
}

TEST(Block, AutomaticChoiceTellsOfCarriedBlocksToo) {
  FlattenedTriangle triangle;
  Positions x = triangle.broken;
  const auto solver = make_resolver(examples::framework_of(triangle.parts), {.tolerance = 1e-6});
  EXPECT_EQ(solver->resolve(x, {.roots = std::vector<int>{2}}).carried, 1);
  EXPECT_EQ(solver->solver(), "block");
}

}  // namespace
}  // namespace ragdoll
