// Tests for core/src/framework.cpp.

#include "ragdoll/framework.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "examples.h"

namespace ragdoll {
namespace {

using examples::refusal_of;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

FrameworkParts chain() {
  FrameworkParts parts;
  parts.masses = {1, 2, 3};
  parts.labels = {"N", "", "C"};
  parts.bars = {{0, 1, 1.0}, {1, 2, 1.5}};
  return parts;
}

/// The refusal of a chain that a change made wrong.
std::string refusal(const std::function<void(FrameworkParts&)>& change) {
  FrameworkParts parts = chain();
  change(parts);
  return refusal_of([&] { Framework{parts}; });
}

TEST(Framework, KeepsItsPartsAndFixesNothingByDefault) {
  const Framework framework(chain());
  EXPECT_EQ(framework.joint_count(), 3);
  EXPECT_EQ(framework.masses(), (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(framework.fixed(), (std::vector<std::uint8_t>{0, 0, 0}));
  EXPECT_EQ(framework.bars()[1].length, 1.5);
  EXPECT_EQ(framework.components().count(), 1);
}

TEST(Framework, JointsWithoutALabelAreNumbered) {
  EXPECT_EQ(Framework(chain()).name(0), "N");
  EXPECT_EQ(Framework(chain()).name(1), "joint 1");
  FrameworkParts parts = chain();
  parts.labels.clear();
  EXPECT_EQ(Framework(parts).name(2), "joint 2");
}

TEST(Framework, BondGraphIsMadeOfTheBarsOfKindBond) {
  FrameworkParts parts = chain();
  parts.bars.push_back({0, 2, 2, BarKind::angle});
  const Framework framework(parts);
  EXPECT_EQ(cycle_rank(framework.graph(), framework.components()), 1);
  EXPECT_EQ(cycle_rank(framework.bond_graph(), framework.bond_components()), 0);
}

TEST(Framework, CountsItsChiralityVolumesOnly) {
  FrameworkParts parts = chain();
  parts.masses.push_back(1);
  parts.labels.push_back("");
  parts.volumes = {{0, 1, 2, 3, 0.5, infinity, 1, VolumeKind::chirality},
                   {0, 1, 2, 3, -0.1, 0.1, 1, VolumeKind::planarity},
                   {3, 2, 1, 0, -infinity, -0.5, 1, VolumeKind::chirality}};
  EXPECT_EQ(Framework(parts).chirality_count(), 2);
}

TEST(Framework, WithoutJointsIsRefused) {
  EXPECT_EQ(refusal_of([] { Framework{FrameworkParts{}}; }), "the framework has no joints");
}

TEST(Framework, SizesThatDisagreeAreRefused) {
  const std::string sentence =
      "the framework's arrays do not have one entry for each of its 3 joints";
  EXPECT_EQ(refusal([](auto& parts) { parts.fixed = {0, 1}; }), sentence);
  EXPECT_EQ(refusal([](auto& parts) { parts.labels = {"a"}; }), sentence);
}

TEST(Framework, MassThatIsNoNumberFromZeroUpIsRefused) {
  for (const double mass : {-1.0, nan, infinity}) {
    EXPECT_EQ(refusal([&](auto& parts) { parts.masses[1] = mass; }),
              "the mass of joint 1 is not a number from 0 up");
  }
  EXPECT_EQ(refusal([](auto& parts) { parts.masses[1] = 0; }), "");
}

TEST(Framework, BarToAnUnknownJointIsRefused) {
  for (const int joint : {-1, 3}) {
    EXPECT_EQ(
        refusal([&](auto& parts) { parts.bars[1].q = joint; }),
        std::string("bar 1 names joint ").append(std::to_string(joint)) + ", but there are 3");
    EXPECT_NE(refusal([&](auto& parts) { parts.bars[1].p = joint; }), "");
  }
}

TEST(Framework, BarFromAJointToItselfIsRefused) {
  EXPECT_EQ(refusal([](auto& parts) { parts.bars[0].q = 0; }), "a bar goes from N to itself");
}

TEST(Framework, TwoBarsOnOnePairAreRefusedEitherWayRound) {
  EXPECT_EQ(refusal([](auto& parts) {
              parts.bars.push_back({1, 0, 1});
            }),
            "two bars join N and joint 1");
  EXPECT_EQ(refusal([](auto& parts) {
              parts.bars.push_back({0, 1, 2});
            }),
            "two bars join N and joint 1");
}

TEST(Framework, LengthThatIsNotPositiveAndFiniteIsRefused) {
  for (const double length : {0.0, -1.0, nan, infinity}) {
    EXPECT_EQ(refusal([&](auto& parts) { parts.bars[0].length = length; }),
              "the bar N - joint 1 has a length that is not a positive number");
    EXPECT_EQ(refusal([&](auto& parts) {
                parts.tethers = {{0, 2, length}};
              }),
              "the tether N - C has a length that is not a positive number");
    EXPECT_EQ(refusal([&](auto& parts) {
                parts.contacts = {{0, 2, length}};
              }),
              "the contact N - C has a length that is not a positive number");
  }
}

TEST(Framework, TethersAndContactsAreCheckedAsBarsAre) {
  EXPECT_NE(refusal([](auto& parts) { parts.tethers = {{0, 3, 1}}; }), "");
  EXPECT_NE(refusal([](auto& parts) { parts.contacts = {{2, 2, 1}}; }), "");
  EXPECT_NE(refusal([](auto& parts) { parts.contacts = {{0, 2, 1}, {2, 0, 1}}; }), "");
  // but a pair may have a bar, a tether and a contact
  EXPECT_EQ(refusal([](auto& parts) {
              parts.tethers = {{0, 1, 2}};
              parts.contacts = {{0, 1, 0.5}};
            }),
            "");
}

TEST(Framework, VolumesThatMakeNoSenseAreRefused) {
  const auto with = [](Volume volume) {
    return refusal([&](auto& parts) {
      parts.masses.push_back(1);
      parts.labels.push_back("");
      parts.volumes = {volume};
    });
  };
  EXPECT_EQ(with({0, 1, 2, 3, -1, 1, 1}), "");
  EXPECT_EQ(with({0, 1, 2, 3, -infinity, -1, 1}), "");
  EXPECT_EQ(with({0, 1, 2, 3, 1, -1, 1}), "volume 0 at N has bounds or a scale that make no sense");
  for (const double scale : {0.0, -1.0, nan, infinity})
    EXPECT_NE(with({0, 1, 2, 3, -1, 1, scale}), "");
  EXPECT_NE(with({0, 1, 2, 3, nan, 1, 1}), "");
  EXPECT_NE(with({0, 1, 2, 4, -1, 1, 1}), "");
}

TEST(Framework, ContactRuleWhoseArraysDisagreeIsRefused) {
  ContactRule whole;
  whole.radii = {0.1, 0.1, 0.1};
  whole.polarity.assign(3, Polarity::none);
  whole.exclusion_begin = {0, 1, 1, 1};
  whole.exclusions = {1};
  const auto with = [&](const std::function<void(ContactRule&)>& change) {
    return refusal([&](auto& parts) {
      parts.contact_rule = whole;
      change(parts.contact_rule);
    });
  };
  EXPECT_EQ(with([](auto&) {}), "");
  EXPECT_NE(with([](auto& rule) { rule.radii.pop_back(); }), "");
  EXPECT_NE(with([](auto& rule) { rule.polarity.clear(); }), "");
  EXPECT_NE(with([](auto& rule) { rule.exclusion_begin = {0, 1, 1}; }), "");
  EXPECT_NE(with([](auto& rule) { rule.exclusion_begin = {0, 1, 0, 1}; }), "");
  EXPECT_NE(with([](auto& rule) { rule.exclusions.clear(); }), "");
}

}  // namespace
}  // namespace ragdoll
