// Tests for core/src/resolver.cpp.

#include "ragdoll/resolver.h"

#include <gtest/gtest.h>

#include <algorithm>  // find
#include <limits>

#include "examples.h"

namespace ragdoll {
namespace {

using namespace examples;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

const Positions square = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};

std::string refusal(const std::string& bars, const ResolverSettings& settings) {
  return refusal_of([&] { make_resolver(framework_of(parts_of(bars, square)), settings); });
}

Violation violation_of(const FrameworkParts& parts, const Positions& positions,
                       const Box* box = nullptr) {
  return worst_violation(Framework(parts), positions, box);
}

// === make_resolver

TEST(Resolver, AutomaticChoiceNamesTheSolverThatWorks) {
  const auto resolver = make_resolver(framework_of(parts_of("ab bc", square)), {});
  const std::vector<std::string> names = solver_names();
  EXPECT_NE(resolver->solver(), "auto");
  EXPECT_NE(std::find(names.begin(), names.end(), resolver->solver()), names.end());
  EXPECT_NE(std::find(names.begin(), names.end(), "auto"), names.end());
}

TEST(Resolver, EverySolverThatIsListedIsMade) {
  for (const std::string& name : solver_names())
    EXPECT_EQ(refusal("ab bc", {.solver = name}), "") << name;
}

TEST(Resolver, UnknownSolverIsRefusedWithTheListOfKnownOnes) {
  const std::string sentence = refusal("ab", {.solver = "magic"});
  EXPECT_NE(sentence.find("'magic'"), std::string::npos);
  for (const std::string& name : solver_names())
    EXPECT_NE(sentence.find(name), std::string::npos) << name;
}

TEST(Resolver, ToleranceThatIsNotPositiveIsRefused) {
  for (const double tolerance : {0.0, -1e-3, nan, infinity})
    EXPECT_EQ(refusal("ab", {.tolerance = tolerance}), "the tolerance must be a positive number");
}

TEST(Resolver, MaximumBelowOneIsRefused) {
  for (const long maximum : {0L, -5L})
    EXPECT_EQ(refusal("ab", {.max_iterations = maximum}),
              "the maximum of iterations must be 1 or more");
}

TEST(Resolver, TreeOrderIsRefusedOnCyclesAndOnlyThere) {
  for (const OrderKind order : {OrderKind::bfs_tree, OrderKind::dfs_tree}) {
    EXPECT_EQ(refusal("ab bc cd", {.order = order}), "");
    EXPECT_EQ(refusal("ab cd", {.order = order}), "");
    const std::string sentence = refusal("ab bc cd da", {.order = order});
    EXPECT_NE(sentence.find(name_of(order)), std::string::npos);
    EXPECT_NE(sentence.find("cycles"), std::string::npos);
    EXPECT_NE(sentence.find("bfs_cycle"), std::string::npos);
  }
}

TEST(Resolver, CustomOrderOfUnknownBarsIsRefused) {
  for (const Visit& visit : {Visit{2, 0, 1}, Visit{-1, 0, 1}, Visit{0, 1, 2}})
    EXPECT_EQ(refusal("ab bc", {.custom_order = {visit}}),
              "the custom order visits a bar that the framework does not have");
  EXPECT_EQ(refusal("ab bc", {.custom_order = {{1, 2, 1}, {0, 0, 1}}}), "");
}

TEST(Resolver, ReasonsAreNamed) {
  EXPECT_EQ(name_of(StopReason::nothing_broken), "nothing broken");
  EXPECT_EQ(name_of(StopReason::within_tolerance), "within tolerance");
  EXPECT_EQ(name_of(StopReason::max_iterations), "maximum of iterations");
  EXPECT_EQ(name_of(StopReason::not_finite), "not a finite number");
  EXPECT_EQ(name_of(StopReason::stagnated), "stagnated");
}

// === worst_violation

TEST(Violation, IsZeroWhereNothingIsBroken) {
  const Violation worst = violation_of(parts_of("ab bc cd da ac", square), square);
  EXPECT_EQ(worst.relative, 0);
  EXPECT_EQ(worst.what, "");
}

TEST(Violation, IsTheLargestRelativeOneAndIsDescribed) {
  FrameworkParts parts;
  parts.masses.assign(4, 1);
  parts.labels = {"CA GLY45", "C GLY45", "", ""};
  // 1 instead of 0.8 is worse than 1 instead of 1.1
  parts.bars = {{1, 2, 1.1}, {0, 1, 0.8}};
  Violation worst = violation_of(parts, square);
  EXPECT_DOUBLE_EQ(worst.relative, 0.25);
  EXPECT_EQ(worst.what, "bar CA GLY45 - C GLY45 is 1 nm long instead of 0.8");

  parts.tethers = {{2, 3, 0.5}};
  worst = violation_of(parts, square);
  EXPECT_DOUBLE_EQ(worst.relative, 1);
  EXPECT_EQ(worst.what, "tether joint 2 - joint 3 is 1 nm long instead of at most 0.5");

  // a contact can be violated by its whole length at most
  parts.tethers.clear();
  parts.contacts = {{0, 3, 4}};
  worst = violation_of(parts, square);
  EXPECT_DOUBLE_EQ(worst.relative, 0.75);
  EXPECT_EQ(worst.what, "contact CA GLY45 - joint 3 is 1 nm long instead of at least 4");
}

TEST(Violation, TethersAreUpperAndContactsLowerBounds) {
  FrameworkParts parts;
  parts.masses.assign(4, 1);
  parts.tethers = {{0, 1, 1.5}};
  parts.contacts = {{0, 1, 0.5}};
  EXPECT_EQ(violation_of(parts, square).relative, 0);
}

TEST(Violation, VolumesAreMeasuredAgainstTheirScale) {
  FrameworkParts parts;
  parts.masses.assign(4, 1);
  const Positions corner = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};  // volume 1
  parts.volumes = {{0, 1, 2, 3, 1.5, infinity, 2}};
  EXPECT_DOUBLE_EQ(violation_of(parts, corner).relative, 0.25);
  EXPECT_EQ(violation_of(parts, corner).what,
            "chirality of joint 0, joint 1, joint 2, joint 3 is outside its bounds");
  parts.volumes = {{0, 1, 2, 3, -0.5, 0.5, 2, VolumeKind::planarity}};
  EXPECT_DOUBLE_EQ(violation_of(parts, corner).relative, 0.25);
  EXPECT_EQ(violation_of(parts, corner).what.substr(0, 9), "planarity");
  parts.volumes = {{0, 1, 2, 3, 0.5, 1.5, 2}};
  EXPECT_EQ(violation_of(parts, corner).relative, 0);
}

TEST(Violation, PairsOfTheContactRuleCountByTheirMinimumImage) {
  FrameworkParts parts;
  parts.masses.assign(2, 1);
  parts.contact_rule.radii = {0.2, 0.2};
  parts.contact_rule.polarity.assign(2, Polarity::none);
  parts.contact_rule.scale = 1;
  parts.contact_rule.exclusion_begin = {0, 0, 0};
  const Box box = {{2, 0, 0}, {0, 2, 0}, {0, 0, 2}};
  const Positions x = {{0.05, 0, 0}, {1.75, 0, 0}};  // 0.3 nm across the face
  EXPECT_EQ(violation_of(parts, x).relative, 0);
  const Violation worst = violation_of(parts, x, &box);
  EXPECT_NEAR(worst.relative, 0.25, 1e-12);
  EXPECT_EQ(worst.what, "contact joint 0 - joint 1 is 0.3 nm long instead of at least 0.4");
  parts.contact_rule.exclusion_begin = {0, 1, 1};
  parts.contact_rule.exclusions = {1};
  EXPECT_EQ(violation_of(parts, x, &box).relative, 0);
}

TEST(Violation, WhatIsNoNumberIsTheWorst) {
  for (const double bad : {nan, infinity}) {
    Positions x = square;
    x[2][0] = bad;
    FrameworkParts parts = parts_of("ab bc cd", square);
    parts.contact_rule.radii.assign(4, 0.2);
    parts.contact_rule.polarity.assign(4, Polarity::none);
    parts.contact_rule.scale = 1;
    parts.contact_rule.exclusion_begin.assign(5, 0);
    const Violation worst = violation_of(parts, x);
    EXPECT_EQ(worst.relative, infinity);
    EXPECT_NE(worst.what.find("joint 2"), std::string::npos);
  }
}

// === inverted_centres

TEST(InvertedCentres, CountChiralityVolumesOfTheWrongSign) {
  FrameworkParts parts;
  parts.masses.assign(4, 1);
  Positions corner = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  parts.volumes = {{0, 1, 2, 3, 0.5, infinity, 1, VolumeKind::chirality},
                   {1, 0, 2, 3, -infinity, -0.5, 1, VolumeKind::chirality},
                   {0, 1, 2, 3, -2, 2, 1, VolumeKind::planarity}};
  const Framework framework(parts);
  EXPECT_EQ(inverted_centres(framework, corner), 0);
  corner[3][2] = 0.01;  // below its bound, but of the right sign
  EXPECT_EQ(inverted_centres(framework, corner), 0);
  corner[3][2] = -1;
  EXPECT_EQ(inverted_centres(framework, corner), 2);
  corner[3][2] = 0;  // flat is not of the right sign
  EXPECT_EQ(inverted_centres(framework, corner), 2);
  corner[3][2] = nan;
  EXPECT_EQ(inverted_centres(framework, corner), 2);
}

}  // namespace
}  // namespace ragdoll
