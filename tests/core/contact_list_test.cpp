// Tests for core/src/contact_list.cpp.

#include "ragdoll/contact_list.h"

#include <gtest/gtest.h>

#include <algorithm>  // any_of, equal

#include "contact_examples.h"
#include "ragdoll/resolver.h"  // make_resolver
#include "vector_targets.h"

namespace ragdoll {
namespace {

using namespace examples;

// === ContactList

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
    // pairs are not chosen each time, and searched for more rarely
    EXPECT_LT(changes, 100);
    EXPECT_LT(list.searches(), changes);
    EXPECT_GT(list.searches(), 1);
  }
}

/// What find_near hands out through a walk must be what brute force finds, whatever came before.
/// @return searches
std::int64_t expect_near_pairs_through_a_walk(const Box* box, double skin, double extent, int steps,
                                              Random& random) {
  const int joints = 60;
  const ContactRule rule = random_rule(joints, random);
  Positions x = random_points(joints, extent, random);
  ContactList list(rule, skin);
  std::vector<NearPair> near;
  std::size_t found = 0;
  for (int step = 0; step < steps; ++step) {
    const double reach = step % 3 == 0 ? 0 : 0.02;
    list.find_near(x, box, reach, near);
    const std::vector<NearPair> expected = near_pairs(rule, x, reach, box);
    EXPECT_TRUE(std::equal(near.begin(), near.end(), expected.begin(), expected.end(), same))
        << "step " << step;
    found += expected.size();
    // small moves of all, and now and then a large one
    for (Vec3& point : x) point += 0.004 * random_vector(random);
    if (step % 40 == 39) x[random.below(std::uint64_t(joints))] = extent * random_vector(random);
  }
  EXPECT_GT(found, std::size_t(steps));
  return list.searches();
}

TEST(ContactList, FindsExactlyTheNearPairsOfEveryStepOfAWalk) {
  Random random = dice(17);
  const std::int64_t searches = expect_near_pairs_through_a_walk(nullptr, 0.1, 0.8, 500, random);
  EXPECT_LT(searches, 50);
  EXPECT_GT(searches, 10);
  for (const Box& box : {rectangular(2, 2.1, 1.9), dodecahedron(1.8), skewed(1.9)})
    EXPECT_LT(expect_near_pairs_through_a_walk(&box, 0.1, 0.8, 300, random), 50);
}

TEST(ContactList, FindsExactlyTheNearPairsWithEveryKindOfVectors) {
  for_each_vector_target([] {
    Random random = dice(18);
    const Box box = dodecahedron(1.8);
    expect_near_pairs_through_a_walk(nullptr, 0.1, 0.8, 100, random);
    expect_near_pairs_through_a_walk(&box, 0.1, 0.8, 100, random);
  });
}

TEST(ContactList, FindsExactlyTheNearPairsInBoxesTooSmallForTheSkin) {
  Random random = dice(19);
  for (const double edge : {0.4, 0.6, 0.8, 1.0, 1.2})
    for (const Box& box : {rectangular(edge, edge, edge), dodecahedron(edge), skewed(edge)})
      expect_near_pairs_through_a_walk(&box, 0.1, 2, 30, random);
}

TEST(ContactList, FindsExactlyTheNearPairsWithAnySkin) {
  Random random = dice(20);
  for (const double skin : {1e-9, 0.01, 0.02, 0.03, 0.5, 30.0})
    expect_near_pairs_through_a_walk(nullptr, skin, 0.8, 50, random);
}

TEST(ContactList, FindsTheNearPairsOfJointsFarAway) {
  Random random = dice(21);
  const int joints = 40;
  const ContactRule rule = random_rule(joints, random);
  for (const double far : {1e3, 1e6, 1e9}) {
    // two groups, one far from the other
    Positions x = random_points(joints, 0.5, random);
    for (int j = 0; j < joints; j += 2) x[std::size_t(j)] += Vec3(far, -far, far);
    ContactList list(rule, 0.1);
    std::vector<NearPair> near;
    for (int step = 0; step < 30; ++step) {
      list.find_near(x, nullptr, 0.02, near);
      const std::vector<NearPair> expected = near_pairs(rule, x, 0.02, nullptr);
      EXPECT_TRUE(std::equal(near.begin(), near.end(), expected.begin(), expected.end(), same));
      EXPECT_FALSE(expected.empty());
      for (Vec3& point : x) point += 0.01 * random_vector(random);
    }
    EXPECT_LT(list.searches(), 10);
  }
}

TEST(ContactList, FindsPairsThatAreHeldFartherApartThanTheirRadiiSay) {
  ContactRule rule = rule_of({0.2, 0.2}, {Polarity::none, Polarity::none});
  rule.close_pairs = {{0, 1, 0.7}};
  ContactList list(rule, 0.1);
  std::vector<NearPair> near;
  list.find_near(Positions{{0, 0, 0}, {0.69, 0, 0}}, nullptr, 0, near);
  ASSERT_EQ(near.size(), 1U);
  EXPECT_EQ(near[0].bound, 0.7);
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

/// So many joints in so little space that each pass moves nearly all of them far.
TEST(ContactList, ResolvingWhereJointsFlyAboutIsResolvingAllPairsBitForBit) {
  Random random = dice(22);
  for (const int joints : {60, 120}) {
    FrameworkParts parts;
    parts.masses.assign(std::size_t(joints), 1);
    parts.contact_rule = random_rule_of_all(joints, random);
    FrameworkParts explicit_parts = parts;
    explicit_parts.contact_rule = {};
    for (const NearPair& pair :
         near_pairs(parts.contact_rule, Positions(std::size_t(joints), Vec3::Zero()), 0, nullptr))
      explicit_parts.contacts.push_back({pair.p, pair.q, pair.bound});
    ResolverSettings settings = crowd_settings();
    settings.max_iterations = 12;
    const auto by_rule = make_resolver(framework_of(parts), settings);
    const auto by_pairs = make_resolver(framework_of(explicit_parts), settings);
    for (int round = 0; round < 3; ++round) {
      Positions x = random_points(joints, 0.2 + 0.1 * round, random), y = x;
      const ResolveReport one = by_rule->resolve(x, {});
      const ResolveReport other = by_pairs->resolve(y, {});
      EXPECT_GT(one.iterations, 5);
      EXPECT_EQ(x, y);
      EXPECT_EQ(one.iterations, other.iterations);
      EXPECT_EQ(one.residual, other.residual);
    }
  }
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
