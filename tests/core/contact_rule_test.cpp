// Tests for core/src/contact_rule.cpp and contact_table.cpp.

#include "ragdoll/contact_rule.h"

#include <gtest/gtest.h>

#include "contact_examples.h"
#include "ragdoll/contact_table.h"  // ContactTable

namespace ragdoll {
namespace {

using namespace examples;

// === ContactRule

TEST(ContactRule, BoundIsTheScaledSumOfRadiiLessTheAllowance) {
  using enum Polarity;
  const ContactRule rule = rule_of({0.1, 0.2, 0.3, 0.4}, {none, heavy, heavy, hydrogen});
  EXPECT_DOUBLE_EQ(rule.rule_bound(0, 1), 0.15);         // one is not polar
  EXPECT_DOUBLE_EQ(rule.rule_bound(0, 3), 0.25);         // one is not polar
  EXPECT_DOUBLE_EQ(rule.rule_bound(1, 2), 0.25 - 0.01);  // two polar heavy atoms
  EXPECT_DOUBLE_EQ(rule.rule_bound(2, 3), 0.35 - 0.05);  // hydrogen and heavy
  EXPECT_DOUBLE_EQ(rule.rule_bound(3, 2), 0.35 - 0.05);
  EXPECT_DOUBLE_EQ(rule.rule_bound(3, 3), 0.4);  // two hydrogens
  EXPECT_DOUBLE_EQ(rule.largest_bound(), 0.4);
}

TEST(ContactRule, JointWithoutARadiusAndBoundBelowZeroTakeNoPart) {
  using enum Polarity;
  const ContactRule rule = rule_of({0, 0.2, 0.04, 0.04}, {none, none, heavy, hydrogen});
  EXPECT_EQ(rule.rule_bound(0, 1), 0);
  EXPECT_EQ(rule.rule_bound(2, 3), 0);
}

TEST(ContactRule, PairThatStartedCloserKeepsItsDistance) {
  ContactRule rule = rule_of({0.2, 0.2, 0.2}, std::vector<Polarity>(3, Polarity::none));
  rule.close_pairs = {{0, 2, 0.07}, {1, 2, 0.13}};
  EXPECT_EQ(rule.bound(0, 2), 0.07);
  EXPECT_EQ(rule.bound(2, 0), 0.07);
  EXPECT_EQ(rule.bound(2, 1), 0.13);
  EXPECT_DOUBLE_EQ(rule.bound(1, 0), 0.2);
}

TEST(ContactRule, ExclusionsAreThoseOfTheLowerJoint) {
  ContactRule rule = rule_of(std::vector<double>(4, 0.2), std::vector<Polarity>(4, Polarity::none));
  rule.exclusions = {1, 3, 2};
  rule.exclusion_begin = {0, 2, 3, 3, 3};
  EXPECT_TRUE(rule.excluded(0, 1));
  EXPECT_FALSE(rule.excluded(0, 2));
  EXPECT_TRUE(rule.excluded(0, 3));
  EXPECT_TRUE(rule.excluded(1, 2));
  EXPECT_FALSE(rule.excluded(2, 3));
}

TEST(ContactRule, WithoutRadiiIsEmpty) {
  EXPECT_TRUE(ContactRule{}.empty());
  EXPECT_EQ(ContactRule{}.largest_bound(), 0);
}

// === ContactTable

TEST(ContactTable, SaysWhatTheRuleSays) {
  Random random = dice(16);
  // exclusions between joints that are many numbers apart too
  const int joints = 150;
  const ContactRule rule = random_rule_of_all(joints, random);
  const ContactTable table(rule);
  int excluded = 0;
  for (int p = 0; p < joints; ++p)
    for (int q = p + 1; q < joints; ++q) {
      EXPECT_EQ(table.excluded(p, q), rule.excluded(p, q));
      EXPECT_EQ(table.bound(p, q), rule.bound(p, q));
      EXPECT_LE(rule.bound(p, q), double(table.shares()[std::size_t(p)]) +
                                      double(table.shares()[std::size_t(q)]) + 1e-6);
      EXPECT_LE(rule.bound(p, q), table.largest_bound());
      excluded += table.excluded(p, q);
    }
  EXPECT_GT(excluded, 100);
}

TEST(ContactTable, KnowsPairsThatAreHeldFartherApartThanTheirRadiiSay) {
  ContactRule rule = rule_of({0.2, 0.2}, {Polarity::none, Polarity::none});
  rule.close_pairs = {{0, 1, 0.7}};
  const ContactTable table(rule);
  EXPECT_EQ(table.bound(0, 1), 0.7);
  EXPECT_GE(table.largest_bound(), 0.7);
}

}  // namespace
}  // namespace ragdoll
