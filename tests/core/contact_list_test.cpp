// Tests for core/src/contact_rule.cpp, cell_list.cpp and contact_list.cpp.

#include "ragdoll/contact_list.h"

#include <gtest/gtest.h>

#include <algorithm>  // sort
#include <cmath>      // sqrt, abs
#include <utility>    // pair

#include "examples.h"
#include "ragdoll/cell_list.h"  // CellList
#include "ragdoll/resolver.h"   // make_resolver

namespace ragdoll {
namespace {

using namespace examples;

using Pairs = std::vector<std::pair<int, int>>;

Random dice(std::uint64_t seed) {
  return Random(seed, RandomStream::generate, 0);
}

Box rectangular(double a, double b, double c) {
  return {{a, 0, 0}, {0, b, 0}, {0, 0, c}};
}

/// OpenMM's reduced forms: a rhombic dodecahedron, and one skewed as far as they allow.
Box dodecahedron(double edge) {
  return {{edge, 0, 0}, {0, edge, 0}, {edge / 2, edge / 2, edge * std::sqrt(0.5)}};
}
Box skewed(double edge) {
  return {{edge, 0, 0}, {-0.5 * edge, 1.1 * edge, 0}, {0.5 * edge, -0.55 * edge, 1.3 * edge}};
}

double distance_of(const Positions& x, int p, int q, const Box* box) {
  const Vec3 d = x[std::size_t(q)] - x[std::size_t(p)];
  return (box ? box->minimum_image(d) : d).norm();
}

Pairs pairs_of(const CellList& cells, int joints) {
  Pairs pairs;
  for (int p = 0; p < joints; ++p) {
    std::vector<int> partners;
    cells.append_partners(p, partners);
    std::sort(partners.begin(), partners.end());
    for (const int q : partners) pairs.emplace_back(p, q);
  }
  return pairs;
}

Pairs brute_force(const Positions& x, double cutoff, const Box* box) {
  Pairs pairs;
  for (int p = 0; p < int(x.size()); ++p)
    for (int q = p + 1; q < int(x.size()); ++q)
      if (distance_of(x, p, q, box) < cutoff) pairs.emplace_back(p, q);
  return pairs;
}

void expect_all_pairs(const Positions& x, double cutoff, const Box* box) {
  const Pairs expected = brute_force(x, cutoff, box);
  EXPECT_EQ(pairs_of(CellList(x, cutoff, box), int(x.size())), expected);
  EXPECT_FALSE(expected.empty());
}

// === Box

TEST(Box, MinimumImageIsTheShortestOfAllImagesWithinHalfTheBox) {
  Random random = dice(1);
  for (const Box& box : {rectangular(1, 2, 3), dodecahedron(2), skewed(2)}) {
    const double half = 0.5 * std::min({box.a[0], box.b[1], box.c[2]});
    int near = 0;
    for (int round = 0; round < 500; ++round) {
      const Vec3 d = 12 * random_vector(random);
      double least = 1e9;
      for (int i = -12; i <= 12; ++i)
        for (int j = -9; j <= 9; ++j)
          for (int k = -9; k <= 9; ++k)
            least = std::min(least, (d + i * box.a + j * box.b + k * box.c).norm());
      const double found = box.minimum_image(d).norm();
      EXPECT_GE(found, least - 1e-9);
      if (least < half) {
        ++near;
        EXPECT_NEAR(found, least, 1e-9);
      }
    }
    EXPECT_GT(near, 50);
  }
}

// === CellList

TEST(CellList, FindsThePairsThatBruteForceFinds) {
  Random random = dice(2);
  for (const double cutoff : {0.1, 0.3, 1.0, 10.0})
    expect_all_pairs(random_points(150, 1.5, random), cutoff, nullptr);
}

TEST(CellList, FindsThePairsOfPeriodicBoxes) {
  Random random = dice(3);
  for (const Box& box : {rectangular(2, 3, 4), dodecahedron(3), skewed(3)})
    for (const double cutoff : {0.2, 0.5, 0.9}) {
      // joints lie in the box and far outside of it
      expect_all_pairs(random_points(150, 2, random), cutoff, &box);
      expect_all_pairs(random_points(150, 40, random), cutoff, &box);
    }
}

TEST(CellList, FindsEachPairOfASmallBoxOnce) {
  // one, two or three cells along each vector
  Random random = dice(4);
  for (const double edge : {0.5, 0.9, 1.0, 1.9, 2.1, 2.9, 3.1})
    for (const Box& box : {rectangular(edge, edge, edge), rectangular(edge, 1.5 * edge, 4),
                           dodecahedron(edge), skewed(edge)})
      expect_all_pairs(random_points(60, 5, random), 0.9, &box);
}

TEST(CellList, FindsJointsOnTheFacesOfTheBox) {
  const Box box = rectangular(2, 2, 2);
  Positions x;
  for (const double c : {-2.0, -1e-17, 0.0, 1e-17, 1.0, 2.0 - 1e-16, 2.0, 4.0})
    x.insert(x.end(), {{c, 0, 0}, {0, c, 0.1}, {0.1, 0, c}});
  expect_all_pairs(x, 0.3, &box);
}

TEST(CellList, JointsThatFlewFarAwayCostNothingAndAreFound) {
  Random random = dice(5);
  Positions x = random_points(60, 1, random);
  for (int j = 0; j < 20; ++j) x.emplace_back(Vec3(1e9, -1e9, 1e9) + random_vector(random));
  for (int j = 0; j < 20; ++j) x.emplace_back(1e9 * random_vector(random));
  x.insert(x.end(), {{1e200, 0, 0}, {1e200, 0, 0}, {-1e200, 0, 0}});
  expect_all_pairs(x, 0.4, nullptr);
  x.resize(x.size() - 3);
  const Box box = rectangular(3, 4, 5);
  expect_all_pairs(x, 0.4, &box);
}

TEST(CellList, PairAtTheCutoffIsNotWithinIt) {
  const Positions x = {{0, 0, 0}, {0.5, 0, 0}, {0.5, 0.25, 0}};
  EXPECT_EQ(pairs_of(CellList(x, 0.5, nullptr), 3), (Pairs{{1, 2}}));
}

TEST(CellList, NoJointsHaveNoPairs) {
  EXPECT_TRUE(pairs_of(CellList(Positions{}, 1, nullptr), 0).empty());
  EXPECT_TRUE(pairs_of(CellList(Positions(1, Vec3::Zero()), 1, nullptr), 1).empty());
}

// === ContactRule

ContactRule rule_of(std::vector<double> radii, std::vector<Polarity> polarity) {
  ContactRule rule;
  rule.exclusion_begin.assign(radii.size() + 1, 0);
  rule.radii = std::move(radii);
  rule.polarity = std::move(polarity);
  rule.scale = 0.5;
  rule.heavy_allowance = 0.01;
  rule.hydrogen_allowance = 0.05;
  return rule;
}

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

// === ContactList

/// Radii, polarities, exclusions and close pairs at random.
ContactRule random_rule(int joints, Random& random) {
  ContactRule rule;
  rule.scale = 0.8;
  rule.heavy_allowance = 0.02;
  rule.hydrogen_allowance = 0.06;
  rule.exclusion_begin = {0};
  for (int p = 0; p < joints; ++p) {
    rule.radii.push_back(random.below(10) == 0 ? 0 : 0.1 + 0.1 * random.uniform());
    rule.polarity.push_back(Polarity(random.below(3)));
    for (int q = p + 1; q < joints; ++q) {
      const std::uint64_t kind = random.below(10);
      if (kind == 0) rule.exclusions.push_back(q);
      if (kind == 1) rule.close_pairs.push_back({p, q, 0.05 + 0.1 * random.uniform()});
    }
    rule.exclusion_begin.push_back(int(rule.exclusions.size()));
  }
  return rule;
}

/// Every pair closer than its bound plus `reach`, with its bound, by the rule's own words.
std::vector<NearPair> near_pairs(const ContactRule& rule, const Positions& x, double reach,
                                 const Box* box) {
  std::vector<NearPair> pairs;
  for (int p = 0; p < int(x.size()); ++p)
    for (int q = p + 1; q < int(x.size()); ++q) {
      if (rule.excluded(p, q) || rule.radii[std::size_t(p)] == 0) continue;
      if (rule.radii[std::size_t(q)] == 0) continue;
      const double bound = rule.bound(p, q);
      if (bound > 0 && distance_of(x, p, q, box) < bound + reach) pairs.push_back({p, q, bound});
    }
  return pairs;
}

bool same(const NearPair& a, const NearPair& b) {
  return a.p == b.p && a.q == b.q && a.bound == b.bound;
}

/// Close pairs of joints without a radius are left out: the rule watches none of theirs.
ContactRule random_rule_of_all(int joints, Random& random) {
  ContactRule rule = random_rule(joints, random);
  for (double& radius : rule.radii) radius = std::max(radius, 0.1);
  return rule;
}

TEST(ContactList, HoldsThePairsWithinReachOfTheirBoundsInOrder) {
  Random random = dice(6);
  for (const bool periodic : {false, true}) {
    const Box box = skewed(1.2);
    const Box* const where = periodic ? &box : nullptr;
    const ContactRule rule = random_rule(80, random);
    const Positions x = random_points(80, 1, random);
    ContactList list(rule, 0.1);
    EXPECT_TRUE(list.update(x, where, 0.03));
    // it holds those up to the skin
    const std::vector<NearPair> expected = near_pairs(rule, x, 0.1, where);
    EXPECT_GT(expected.size(), 100U);
    EXPECT_TRUE(std::equal(list.pairs().begin(), list.pairs().end(), expected.begin(),
                           expected.end(), same));
  }
}

TEST(ContactList, NeverMissesAPairWhileJointsMove) {
  Random random = dice(7);
  for (const bool periodic : {false, true}) {
    const Box box = dodecahedron(1.5);
    const Box* const where = periodic ? &box : nullptr;
    const ContactRule rule = random_rule(60, random);
    Positions x = random_points(60, 1, random);
    ContactList list(rule, 0.1);
    std::int64_t changes = 0;
    for (int move = 0; move < 300; ++move) {
      changes += list.update(x, where, 0.02);
      for (const NearPair& pair : near_pairs(rule, x, 0.02, where))
        ASSERT_TRUE(std::any_of(list.pairs().begin(), list.pairs().end(),
                                [&](const NearPair& kept) { return same(kept, pair); }));
      for (Vec3& point : x) point += 0.01 * random_vector(random);
    }
    EXPECT_EQ(list.searches(), changes);
    // and does not search each time
    EXPECT_LT(changes, 100);
    EXPECT_GT(changes, 3);
  }
}

TEST(ContactList, SearchesAnewWhenTwoJointsMayHaveMetHalfWay) {
  ContactRule rule = rule_of({0.4, 0.4}, {Polarity::none, Polarity::none});
  ContactList list(rule, 0.1);
  // 0.001 nm beyond the skin of a bound of 0.4 nm; then each moves by just over half the skin
  Positions x = {{0, 0, 0}, {0.501, 0, 0}};
  list.update(x, nullptr, 0);
  EXPECT_TRUE(list.pairs().empty());
  x = {{0.051, 0, 0}, {0.450, 0, 0}};
  EXPECT_TRUE(list.update(x, nullptr, 0));
  ASSERT_EQ(list.pairs().size(), 1U);
  // moves below half of what the reach leaves of the skin are no reason to search
  x = {{0.061, 0, 0}, {0.440, 0, 0}};
  EXPECT_FALSE(list.update(x, nullptr, 0.05));
  EXPECT_TRUE(list.update(x, nullptr, 0.09));
}

TEST(ContactList, SearchesAnewWhenTheBoxChanges) {
  Random random = dice(8);
  const ContactRule rule = random_rule(20, random);
  const Positions x = random_points(20, 1, random);
  const Box box = rectangular(2, 2, 2), larger = rectangular(2, 2, 2.5);
  ContactList list(rule, 0.1);
  EXPECT_TRUE(list.update(x, nullptr, 0));
  EXPECT_FALSE(list.update(x, nullptr, 0));
  EXPECT_TRUE(list.update(x, &box, 0));
  EXPECT_FALSE(list.update(x, &box, 0));
  EXPECT_TRUE(list.update(x, &larger, 0));
  EXPECT_TRUE(list.update(x, nullptr, 0));
}

TEST(ContactList, ReachAsLargeAsTheSkinIsSearchedForEachTime) {
  Random random = dice(9);
  const ContactRule rule = random_rule(20, random);
  const Positions x = random_points(20, 1, random);
  ContactList list(rule, 0.1);
  EXPECT_TRUE(list.update(x, nullptr, 0.1));
  EXPECT_TRUE(list.update(x, nullptr, 0.1));
}

// === Contacts while resolving: as if every pair were looked at in each pass

/// A tree with contacts by rule, in some disorder.
struct Crowd {
  FrameworkParts parts;
  Positions positions;
  std::vector<Contact> all_pairs;  ///< the rule's, sorted by (p, q)
};

Crowd crowd_of(int joints, Random& random) {
  Structure structure = random_structure(joints, 2, random);
  Crowd crowd;
  crowd.parts = structure.parts;
  crowd.positions = structure.positions;
  crowd.parts.contact_rule = random_rule_of_all(joints, random);
  for (int p = 0; p < joints; ++p)
    for (int q = p + 1; q < joints; ++q) {
      const double bound = crowd.parts.contact_rule.bound(p, q);
      if (!crowd.parts.contact_rule.excluded(p, q) && bound > 0)
        crowd.all_pairs.push_back({p, q, bound});
    }
  // a large move of one joint and small ones of all
  const Vec3 push = 2 * random_vector(random);
  crowd.positions[random.below(std::uint64_t(joints))] += push;
  for (Vec3& point : crowd.positions) point += 0.2 * random_vector(random);
  return crowd;
}

ResolverSettings crowd_settings() {
  ResolverSettings settings;
  settings.solver = "ordered";
  settings.max_iterations = 400;
  return settings;
}

TEST(ContactList, ResolvingByTheRuleIsResolvingAllItsPairsBitForBit) {
  Random random = dice(10);
  int converged = 0;
  std::int64_t iterations = 0;
  for (int round = 0; round < 30; ++round) {
    const Crowd crowd = crowd_of(10 + round, random);
    FrameworkParts explicit_parts = crowd.parts;
    explicit_parts.contact_rule = {};
    explicit_parts.contacts = crowd.all_pairs;
    const auto by_rule = make_resolver(framework_of(crowd.parts), crowd_settings());
    const auto by_pairs = make_resolver(framework_of(explicit_parts), crowd_settings());

    // one resolver through several breaks: its list is kept from one to the next
    Positions x = crowd.positions, y = crowd.positions;
    for (int force = 0; force < 4; ++force) {
      const std::vector<int> roots = {force};
      const ResolveReport one = by_rule->resolve(x, {.roots = roots});
      const ResolveReport other = by_pairs->resolve(y, {.roots = roots});
      EXPECT_EQ(x, y);
      EXPECT_EQ(one.iterations, other.iterations);
      EXPECT_EQ(one.bar_visits, other.bar_visits);
      EXPECT_EQ(one.converged, other.converged);
      EXPECT_EQ(one.residual, other.residual);
      EXPECT_EQ(one.worst, other.worst);
      converged += one.converged;
      iterations += one.iterations;
      const Vec3 push = random_vector(random);
      x[std::size_t(force)] += push;
      y[std::size_t(force)] += push;
    }
  }
  EXPECT_GT(converged, 20);
  EXPECT_GT(iterations, 500);
}

TEST(ContactList, ResolvingInABoxIsResolvingAllMinimumImagesBitForBit) {
  Random random = dice(11);
  const double tol = 1e-3;
  std::int64_t iterations = 0;
  for (const Box& box : {rectangular(1.4, 1.5, 1.6), dodecahedron(1.6), skewed(1.4)})
    for (int round = 0; round < 20; ++round) {
      // no bars: the rule alone, over all pairs, in each pass
      Crowd crowd = crowd_of(25, random);
      crowd.parts.bars.clear();
      ResolverSettings settings = crowd_settings();
      settings.tolerance = tol;
      Positions x = crowd.positions, y = crowd.positions;
      const ResolveReport report =
          make_resolver(framework_of(crowd.parts), settings)->resolve(x, {.box = &box});

      std::int64_t passes = 0;
      for (bool broken = true; broken && passes < settings.max_iterations;) {
        broken = false;
        for (const Contact& pair : crowd.all_pairs) {
          Vec3& p = y[std::size_t(pair.p)];
          Vec3& q = y[std::size_t(pair.q)];
          const Vec3 d = box.minimum_image(q - p);
          const double distance = d.norm(), error = pair.length - distance;
          if (error <= tol * pair.length) continue;
          const Vec3 unit = d / distance;
          p -= 0.5 * error * unit;
          q += 0.5 * error * unit;
          broken = true;
        }
        passes += broken;
      }
      EXPECT_EQ(x, y);
      EXPECT_EQ(report.iterations, passes);
      iterations += passes;
    }
  EXPECT_GT(iterations, 100);
}

TEST(ContactList, ResolvedJointsKeepTheirDistance) {
  Random random = dice(12);
  for (int round = 0; round < 10; ++round) {
    Crowd crowd = crowd_of(30, random);
    crowd.parts.bars.clear();
    Positions x = crowd.positions;
    const ResolveReport report =
        make_resolver(framework_of(crowd.parts), crowd_settings())->resolve(x, {});
    ASSERT_TRUE(report.converged);
    for (const Contact& pair : crowd.all_pairs)
      EXPECT_GE(distance_of(x, pair.p, pair.q, nullptr), pair.length * (1 - 1e-3) - 1e-12);
  }
}

TEST(ContactList, JointsFarAwayAreResolvedAsQuickly) {
  Random random = dice(13);
  Crowd crowd = crowd_of(20, random);
  crowd.parts.bars.clear();
  Positions x = crowd.positions, far = x;
  far[3] = {1e9, -1e9, 1e9};
  far[7] = {1e9, -1e9, 1e9 + 0.05};
  const ResolveReport report =
      make_resolver(framework_of(crowd.parts), crowd_settings())->resolve(far, {});
  EXPECT_TRUE(report.converged);
}

}  // namespace
}  // namespace ragdoll
