// Tests for core/src/classify.cpp.

#include <gtest/gtest.h>

#include <algorithm>  // find, sort
#include <set>

#include "naive_classify.h"
#include "ragdoll/classify.h"
#include "ragdoll/random.h"

namespace ragdoll {
namespace {

using naive::Bars;

/// Each pair has a bar with the given probability, in random order.
Bars random_bars(int joints, double probability, Random& random) {
  Bars bars;
  for (int q = 0; q < joints; ++q)
    for (int p = 0; p < q; ++p)
      if (random.uniform() < probability) bars.emplace_back(p, q);
  for (std::size_t k = bars.size(); k > 1; --k) std::swap(bars[k - 1], bars[random.below(k)]);
  return bars;
}

/// Calls `check` with many small graphs of any density, connected or not.
template <class Check>
void for_small_graphs(Check check) {
  for (std::uint64_t seed = 0; seed < 1500; ++seed) {
    Random random(seed, RandomStream::generate, 0);
    const int joints = 1 + int(random.below(10));
    const Bars bars = random_bars(joints, 0.1 + 0.3 * random.uniform(), random);
    check(joints, bars, classify(Graph(joints, bars)));
    if (::testing::Test::HasFailure()) FAIL() << "seed " << seed;
  }
}

// === Against the definitions

TEST(Classify, BridgesAreTheBarsWhoseRemovalPartsTheGraph) {
  for_small_graphs([](int joints, const Bars& bars, const Classification& found) {
    std::vector<int> bridges;
    for (int k = 0; k < int(bars.size()); ++k)
      if (naive::is_bridge(joints, bars, k)) bridges.push_back(k);
    EXPECT_EQ(found.bridges, bridges);
  });
}

TEST(Classify, ArticulationJointsAreThoseWhoseRemovalPartsTheGraph) {
  for_small_graphs([](int joints, const Bars& bars, const Classification& found) {
    std::vector<int> expected;
    for (int j = 0; j < joints; ++j) {
      const bool alone = std::none_of(bars.begin(), bars.end(), [&](const auto& bar) {
        return bar.first == j || bar.second == j;
      });
      if (!alone &&
          naive::component_count(joints, bars, -1, j) > naive::component_count(joints, bars))
        expected.push_back(j);
    }
    EXPECT_EQ(found.articulation_joints, expected);
  });
}

TEST(Classify, BlocksAreTheSetsOfBarsThatNoJointParts) {
  for_small_graphs([](int joints, const Bars& bars, const Classification& found) {
    std::set<std::set<int>> blocks;
    for (const Block& block : found.blocks)
      blocks.insert(std::set<int>(block.bars.begin(), block.bars.end()));
    EXPECT_EQ(blocks, naive::cycle_blocks(joints, bars));
  });
}

TEST(Classify, CycleRankIsThatOfTheComponentsAndOfTheBlocksTogether) {
  for_small_graphs([](int joints, const Bars& bars, const Classification& found) {
    int by_component = 0, by_block = 0;
    for (const ComponentClass& component : found.components) by_component += component.cycle_rank;
    for (const Block& block : found.blocks) by_block += block.cycle_rank();
    EXPECT_EQ(found.cycle_rank, naive::cycle_rank(joints, bars));
    EXPECT_EQ(by_component, found.cycle_rank);
    EXPECT_EQ(by_block, found.cycle_rank);
  });
}

TEST(Classify, TypesOfTwoCyclesAreThoseOfTheirPrunedShape) {
  std::set<std::string> types;
  for_small_graphs([&](int joints, const Bars& bars, const Classification& found) {
    if (found.components.size() != 1) return;
    EXPECT_EQ(found.class_name, naive::class_of(joints, bars));
    EXPECT_EQ(found.type, naive::type_of(joints, bars));
    types.insert(found.type);
  });
  EXPECT_EQ(types, (std::set<std::string>{"", "path", "shared-joint", "theta"}));
}

TEST(Classify, DiameterIsExactOnTreesAndNeverTooLarge) {
  for_small_graphs([&](int joints, const Bars& bars, const Classification& found) {
    if (found.components.size() != 1) return;
    const int exact = naive::diameter_of(joints, bars);
    EXPECT_LE(found.diameter, exact);
    if (found.cycle_rank == 0) {
      EXPECT_EQ(found.diameter, exact);
    }
  });
}

TEST(Classify, EveryBarIsABridgeOrInOneBlock) {
  for_small_graphs([](int, const Bars& bars, const Classification& found) {
    std::vector<int> all = found.bridges;
    for (const Block& block : found.blocks)
      all.insert(all.end(), block.bars.begin(), block.bars.end());
    std::sort(all.begin(), all.end());
    ASSERT_EQ(all.size(), bars.size());
    for (std::size_t k = 0; k < all.size(); ++k) EXPECT_EQ(all[k], int(k));
  });
}

// === Examples

TEST(Classify, LargestComponentNamesTheClass) {
  // a triangle and a path of four joints
  const Bars bars = {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 6}};
  const Classification found = classify(Graph(7, bars));
  EXPECT_EQ(found.class_name, "tree");
  EXPECT_EQ(found.diameter, 3);
  ASSERT_EQ(found.components.size(), 2u);
  EXPECT_EQ(found.components[0].class_name, "1-cycle");
  EXPECT_EQ(found.components[1].lowest_joint, 3);
  EXPECT_EQ(found.blocks.at(0).joints, (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(found.blocks.at(0).component, 0);
}

TEST(Classify, SingleJointIsATreeWithoutBridges) {
  const Classification found = classify(Graph(1, Bars{}));
  EXPECT_EQ(found.class_name, "tree");
  EXPECT_EQ(found.diameter, 0);
  EXPECT_TRUE(found.bridges.empty());
}

TEST(Classify, ChainOfAMillionJointsNeedsNoDeepStack) {
  const int joints = 1'000'000;
  Bars bars;
  for (int j = 1; j < joints; ++j) bars.emplace_back(j - 1, j);
  const Classification open = classify(Graph(joints, bars));
  EXPECT_EQ(open.bridges.size(), bars.size());
  EXPECT_EQ(open.diameter, joints - 1);
  bars.emplace_back(joints - 1, 0);
  const Classification closed = classify(Graph(joints, bars));
  EXPECT_EQ(closed.class_name, "1-cycle");
  EXPECT_TRUE(closed.bridges.empty());
  EXPECT_EQ(closed.diameter, joints / 2);
}

}  // namespace
}  // namespace ragdoll
