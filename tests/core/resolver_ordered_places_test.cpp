// Tests for core/src/joint_places.cpp: large frameworks whose joints' numbers lie scattered are
// resolved as they always were. An order given by the caller is swept by the joints' own numbers:
// that is what the others are held against.

#include <gtest/gtest.h>

#include <algorithm>  // shuffle
#include <numeric>    // iota
#include <random>     // mt19937_64

#include "joint_places.h"
#include "ordered_examples.h"

namespace ragdoll {
namespace {

using namespace examples;

constexpr int joints = 60000;

/// A ladder without every third rung, its joints numbered anyhow, with what else holds joints.
struct ScatteredLadder {
  FrameworkParts parts;
  Positions x;

  explicit ScatteredLadder(bool others) {
    std::vector<int> number(joints);
    std::iota(number.begin(), number.end(), 0);
    std::mt19937_64 random(3);
    std::shuffle(number.begin(), number.end(), random);
    const auto joint = [&](int k) { return number[std::size_t(k)]; };
    parts.masses.assign(joints, 1.0);
    parts.fixed.assign(joints, 0);
    x.resize(joints);
    for (int k = 0; k < joints; ++k) {
      x[std::size_t(joint(k))] = Vec3(k / 2, k % 2, 0.1 * (k % 3));
      // the last two joints are alone
      if (k >= 2 && k < joints - 2) parts.bars.push_back({joint(k), joint(k - 2), 1});
      if (k % 2 == 1 && k % 3 != 0) parts.bars.push_back({joint(k), joint(k - 1), 1});
      if (!others || k < 8 || k >= joints - 2) continue;
      if (k % 5 == 0) parts.tethers.push_back({joint(k), joint(k - 4), 1.9});
      if (k % 7 == 0) parts.contacts.push_back({joint(k), joint(k - 6), 3.05});
      if (k % 50 == 0)
        parts.volumes.push_back({joint(k), joint(k - 1), joint(k - 2), joint(k - 5), -0.2, 0.2, 1});
      if (k % 1000 == 0) parts.fixed[std::size_t(joint(k))] = 1;
    }
    std::shuffle(parts.bars.begin(), parts.bars.end(), random);
    Random noise = dice(4);
    for (Vec3& point : x) point += 0.1 * Vec3(noise.gaussian(), noise.gaussian(), noise.gaussian());
  }
};

void expect_same(const ScatteredLadder& ladder, ResolverSettings settings,
                 const std::vector<int>& roots) {
  const auto framework = framework_of(ladder.parts);
  settings.solver = "ordered";
  Random unused = dice(1);
  ResolverSettings by_number = settings;
  by_number.custom_order = order_of(framework->graph(), settings.order, roots, unused);
  ASSERT_TRUE(JointPlaces::pay(by_number.custom_order, joints,
                               settings.precision == Precision::single ? 12 : 24));
  const auto in_places = make_resolver(framework, settings);
  const auto as_numbered = make_resolver(framework, by_number);
  Positions x = ladder.x, y = ladder.x;
  // again, from what was resolved, with another joint out of place
  for (int step = 0; step < 2; ++step) {
    const ResolveReport a = in_places->resolve(x, {.roots = roots});
    const ResolveReport b = as_numbered->resolve(y, {.roots = roots});
    ASSERT_TRUE(x == y) << name_of(settings.order);
    EXPECT_EQ(a.iterations, b.iterations);
    EXPECT_EQ(a.bar_visits, b.bar_visits);
    EXPECT_EQ(a.residual, b.residual);
    EXPECT_EQ(a.residual_nm, b.residual_nm);
    EXPECT_EQ(a.converged, b.converged);
    EXPECT_EQ(a.reason, b.reason);
    EXPECT_EQ(a.worst, b.worst);
    x[17] += Vec3(0.3, 0, 0);
    y[17] += Vec3(0.3, 0, 0);
  }
}

TEST(OrderedPlaces, BarsEndWithTheSameBitsAndCounts) {
  const ScatteredLadder ladder(false);
  for (const OrderKind kind :
       {OrderKind::bfs_cycle, OrderKind::dfs_cycle, OrderKind::bfs_reverse, OrderKind::dfs_reverse})
    expect_same(ladder, {.order = kind, .tolerance = 0.05, .max_iterations = 300}, {11, 40000});
}

TEST(OrderedPlaces, TethersContactsVolumesAndFixedJointsDoToo) {
  const ScatteredLadder ladder(true);
  expect_same(ladder, {.weighting = uneven, .tolerance = 0.1, .max_iterations = 300}, {11});
}

TEST(OrderedPlaces, BreaksThatAreNotResolvedEndAlike) {
  const ScatteredLadder ladder(true);
  expect_same(ladder, {.tolerance = Tolerance::nanometers(1e-6), .max_iterations = 4}, {11});
}

TEST(OrderedPlaces, FloatsDoToo) {
  // floats are fewer bytes: these joints would fit
  ScatteredLadder ladder(false);
  constexpr int more = 40000;
  ladder.parts.masses.resize(joints + more, 1.0);
  ladder.parts.fixed.resize(joints + more, 0);
  ladder.x.resize(joints + more, Vec3(0, 0, 0));
  const auto framework = framework_of(ladder.parts);
  ResolverSettings settings;
  settings.solver = "ordered";
  settings.precision = Precision::single;
  settings.tolerance = Tolerance::nanometers(0.05);
  Random unused = dice(1);
  const std::vector<int> root = {11};
  ResolverSettings by_number = settings;
  by_number.custom_order = order_of(framework->graph(), settings.order, root, unused);
  ASSERT_TRUE(JointPlaces::pay(by_number.custom_order, joints + more, 12));
  Positions x = ladder.x, y = ladder.x;
  const ResolveReport a = make_resolver(framework, settings)->resolve(x, {.roots = root});
  const ResolveReport b = make_resolver(framework, by_number)->resolve(y, {.roots = root});
  EXPECT_TRUE(a.converged);
  EXPECT_TRUE(x == y);
  EXPECT_EQ(a.iterations, b.iterations);
  EXPECT_EQ(a.residual, b.residual);
}

TEST(OrderedPlaces, AnotherRootIsAnotherOrder) {
  const ScatteredLadder ladder(true);
  const auto framework = framework_of(ladder.parts);
  ResolverSettings settings;
  settings.solver = "ordered";
  settings.tolerance = 0.1;
  settings.max_iterations = 300;
  const auto kept = make_resolver(framework, settings);
  for (const int root : {11, 40000}) {
    Positions x = ladder.x, y = ladder.x;
    kept->resolve(x, {.roots = {&root, 1}});
    make_resolver(framework, settings)->resolve(y, {.roots = {&root, 1}});
    EXPECT_TRUE(x == y);
  }
}

TEST(OrderedPlaces, ArePaidForOnlyWhereNumbersLieScattered) {
  Order along, anyhow;
  Random random = dice(5);
  const auto any = [&] { return int(random.below(joints)); };
  for (int k = 1; k < joints; ++k) {
    along.push_back({k - 1, k - 1, k, false});
    anyhow.push_back({k - 1, any(), any(), false});
  }
  EXPECT_FALSE(JointPlaces::pay(along, joints, 24));
  EXPECT_TRUE(JointPlaces::pay(anyhow, joints, 24));
  EXPECT_FALSE(JointPlaces::pay(anyhow, 40000, 24)) << "the caches hold all of it";
}

}  // namespace
}  // namespace ragdoll
