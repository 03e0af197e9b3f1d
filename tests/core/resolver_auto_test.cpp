// Tests for core/src/resolver_auto.cpp.

#include <gtest/gtest.h>

#include "block_examples.h"

namespace ragdoll {
namespace {

using namespace block_examples;
using examples::random_vector;

const Positions two_chains = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 9, 0}, {1, 9, 0}, {2, 9, 0}};

/// A chain of bars alone, and one with a tether.
FrameworkParts mixed() {
  FrameworkParts parts = parts_of("ab bc de ef", two_chains);
  parts.tethers = {{3, 5, 1.5}};
  return parts;
}

std::unique_ptr<Resolver> automatic(const FrameworkParts& parts, const Tolerance& tolerance) {
  return make_resolver(examples::framework_of(parts), {.solver = "auto", .tolerance = tolerance});
}

TEST(Auto, ForcedJointsOnBarsGoToBlockAndBreaksOfAllToTheOthersByTolerance) {
  for (const double tolerance : {1e-2, 1e-8}) {
    const auto resolver = automatic(parts_of("ab bc de ef", two_chains), tolerance);
    const std::string all = tolerance > 1e-3 ? "ordered" : "newton";
    EXPECT_EQ(resolver->solver(), all);
    Positions x = two_chains;
    x[1] += Vec3(0.2, 0.9, 0.4);
    EXPECT_TRUE(resolver->resolve(x, {.roots = std::vector<int>{1}}).converged);
    EXPECT_EQ(resolver->solver(), "block");
    x[2] += Vec3(0.2, 0.9, 0.4);
    EXPECT_TRUE(resolver->resolve(x, {}).converged);
    EXPECT_EQ(resolver->solver(), all);
  }
}

TEST(Auto, ChoosesPerComponentAndTells) {
  const FrameworkParts parts = mixed();
  const auto resolver = automatic(parts, 1e-2);
  EXPECT_EQ(resolver->solver(), "ordered");
  Positions x = two_chains;
  for (const std::size_t j : {1U, 4U}) x[j] += Vec3(0.2, 0.9, 0.4);
  const std::vector<int> roots = {1, 4};
  const ResolveReport report = resolver->resolve(x, {.roots = roots});
  EXPECT_EQ(resolver->solver(), "block (1 component), ordered (1 component)");
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.reason, StopReason::within_tolerance);
  const Violation worst = worst_violation(Framework(parts), x, nullptr);
  EXPECT_LE(worst.relative, 1e-2);
  EXPECT_NEAR(report.residual, worst.relative, 1e-12);
  EXPECT_EQ(resolver->solver().find("auto"), std::string::npos);
}

TEST(Auto, ManyTethersInALargePieceAreForOrderedUnlessTheToleranceIsTight) {
  // a chain of 400 joints, folded so that joints far along it are tethered
  FrameworkParts parts;
  parts.masses.assign(400, 1);
  for (int j = 0; j < 399; ++j) parts.bars.push_back({j, j + 1, 0.15});
  EXPECT_EQ(automatic(parts, 1e-5)->solver(), "newton");
  for (int j = 0; j < 20; ++j) parts.tethers.push_back({j, 399 - j, 50});
  EXPECT_EQ(automatic(parts, 5e-3)->solver(), "ordered");
  EXPECT_EQ(automatic(parts, 1e-3)->solver(), "newton");
  parts.tethers.resize(4);
  EXPECT_EQ(automatic(parts, 5e-3)->solver(), "newton");
}

TEST(Auto, PiecesAreResolvedAsEachWouldBeAlone) {
  FrameworkParts bars = parts_of("ab bc", {two_chains.begin(), two_chains.begin() + 3});
  FrameworkParts tethered = bars;
  tethered.tethers = {{0, 2, 1.5}};
  const auto together = automatic(mixed(), 1e-2);
  const auto first = automatic(bars, 1e-2), second = automatic(tethered, 1e-2);
  Positions x = two_chains, a(x.begin(), x.begin() + 3), b(x.begin() + 3, x.end());
  Random random(4, RandomStream::generate, 0);
  bool before = false;
  for (int step = 0; step < 20; ++step) {
    const int root = int(random.below(6));
    Positions& part = root < 3 ? a : b;
    const Vec3 move = random_vector(random);
    x[std::size_t(root)] += move;
    part[std::size_t(root % 3)] += move;
    const int local = root % 3;
    const auto& alone = root < 3 ? first : second;
    const ResolveReport one = together->resolve(
        x, {.roots = {&root, 1}, .step = std::uint64_t(step), .only_roots_moved = before});
    alone->resolve(part, {.roots = {&local, 1}, .step = std::uint64_t(step)});
    before = one.converged;
    EXPECT_TRUE(one.converged);
    if (step == 0) continue;  // the other part is looked at for the first time
    for (std::size_t j = 0; j < 3; ++j) {
      EXPECT_EQ(x[j], a[j]) << step;
      EXPECT_EQ(x[j + 3], b[j]) << step;
    }
  }
}

TEST(Auto, WhatAContactRuleCouplesIsResolvedByOneSolver) {
  FrameworkParts parts = parts_of("ab bc de ef", two_chains);
  parts.contact_rule.radii.assign(6, 0.4);
  parts.contact_rule.polarity.assign(6, Polarity::none);
  parts.contact_rule.scale = 1;
  parts.contact_rule.exclusion_begin.assign(7, 0);
  const auto resolver = automatic(parts, 1e-2);
  Positions x = two_chains;
  x[4] = x[1] + Vec3(0.3, 0.1, 0.2);
  EXPECT_TRUE(resolver->resolve(x, {.roots = std::vector<int>{4}}).converged);
  EXPECT_EQ(resolver->solver(), "ordered");
  EXPECT_LE(worst_violation(Framework(parts), x, nullptr).relative, 1e-2);
}

TEST(Auto, WorstConstraintOfAnyPieceIsNamed) {
  FrameworkParts parts = mixed();
  parts.labels = {"A", "B", "C", "D", "E", "F"};
  parts.fixed = {0, 0, 0, 1, 1, 0};
  Positions x = two_chains;
  x[3] -= Vec3(1, 0, 0);
  const ResolveReport report = automatic(parts, 1e-2)->resolve(x, {.roots = std::vector<int>{0}});
  EXPECT_FALSE(report.converged);
  EXPECT_EQ(report.worst.substr(0, 9), "bar D - E");
}

TEST(Auto, JointsThatNothingHoldsGoAlong) {
  FrameworkParts parts = parts_of("ab bc", two_chains);
  const auto resolver = automatic(parts, 1e-2);
  EXPECT_EQ(resolver->solver(), "ordered");
  Positions x = two_chains;
  x[1] += Vec3(0.2, 0.9, 0.4);
  x[4] += Vec3(1, 1, 1);
  const Vec3 alone = x[4];
  EXPECT_TRUE(resolver->resolve(x, {.roots = std::vector<int>{1}}).converged);
  EXPECT_EQ(resolver->solver(), "block");
  EXPECT_EQ(x[4], alone);
  EXPECT_EQ(automatic(parts_of("", two_chains), 1e-2)->solver(), "ordered");
}

TEST(Auto, UnknownRootIsRefused) {
  Positions x = two_chains;
  for (const int root : {-1, 6})
    EXPECT_NE(examples::refusal_of([&] {
                automatic(mixed(), 1e-2)->resolve(x, {.roots = {&root, 1}});
              }),
              "");
}

}  // namespace
}  // namespace ragdoll
