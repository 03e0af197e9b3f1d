// Tests for core/src/hinge_groups.cpp.

#include "ragdoll/hinge_groups.h"

#include <gtest/gtest.h>

#include <algorithm>  // sort
#include <tuple>

#include "body_bar_examples.h"

namespace ragdoll {
namespace {

using namespace examples;

using Group = std::pair<int, std::vector<int>>;

std::vector<Group> sorted(const std::vector<HingeGroup>& groups) {
  std::vector<Group> list;
  for (const HingeGroup& group : groups) list.emplace_back(group.freedom, group.hinges);
  std::sort(list.begin(), list.end());
  return list;
}

std::vector<HingeGroup> groups_of(const BodyBarNetwork& network) {
  return hinge_groups(network, analyse_rigidity(network));
}

TEST(HingeGroups, EveryHingeOfAChainTurnsAlone) {
  EXPECT_EQ(sorted(groups_of(chain_of(4, 5))), (std::vector<Group>{{1, {0}}, {1, {1}}, {1, {2}}}));
}

TEST(HingeGroups, ARingOfEightTurnsTogetherByTwoFreedoms) {
  EXPECT_EQ(sorted(groups_of(ring_of(8, 5))), (std::vector<Group>{{2, {0, 1, 2, 3, 4, 5, 6, 7}}}));
}

TEST(HingeGroups, RingsThatShareABodyTurnEachForItself) {
  BodyBarNetwork network = ring_of(7, 5);
  network.bodies = 14;
  int last = 0;  // the second ring starts and ends at body 0
  for (int body = 7; body < 14; ++body) {
    network.bonds.push_back({last, body, 5});
    last = body;
  }
  network.bonds.push_back({13, 0, 5});
  EXPECT_EQ(sorted(groups_of(network)),
            (std::vector<Group>{{1, {0, 1, 2, 3, 4, 5, 6}}, {2, {7, 8, 9, 10, 11, 12, 13, 14}}}));
}

TEST(HingeGroups, RigidNetworksHaveNone) {
  EXPECT_TRUE(groups_of(ring_of(6, 5)).empty());
}

/// A ring of hinges, and ears: chains of hinges between two bodies that are there already.
BodyBarNetwork random_rings(Random& random) {
  BodyBarNetwork network = ring_of(7 + int(random.below(3)), 5);
  for (std::uint64_t ears = random.below(3); ears > 0; --ears) {
    int last = int(random.below(std::uint64_t(network.bodies)));
    // half of them are rings of their own
    const int end = random.below(2) == 0 ? last : int(random.below(std::uint64_t(network.bodies)));
    for (std::uint64_t more = 3 + random.below(6); more > 0; --more) {
      network.bonds.push_back({last, network.bodies, 5});
      last = network.bodies++;
    }
    network.bonds.push_back({last, end, 5});
  }
  if (random.below(2) == 0) network.bonds.push_back({0, 3, 1 + int(random.below(2))});
  return network;
}

TEST(HingeGroups, RandomRingsAgreeWithTheMotionsOfTheirRigidityMatrix) {
  Random random(5, RandomStream::generate, 0);
  int coupled = 0, several = 0;
  for (int round = 0; round < 60; ++round) {
    const BodyBarNetwork network = random_rings(random);
    const Rigidity rigidity = analyse_rigidity(network);
    const RigidityMatrix matrix(network, random);
    const std::vector<HingeGroup> groups = hinge_groups(network, rigidity);
    ASSERT_EQ(sorted(groups), sorted(matrix.hinge_groups(rigidity.hinges))) << round;
    several += groups.size() > 1;
    for (const HingeGroup& group : groups) coupled += group.hinges.size() > 1;
  }
  EXPECT_GT(coupled, 30);
  EXPECT_GE(several, 4);
}

TEST(HingeGroups, TheirFreedomsAddUpToTheFloppyModesOfANetworkOfHinges) {
  Random random(6, RandomStream::generate, 0);
  for (int round = 0; round < 50; ++round) {
    BodyBarNetwork network = random_network(60, 66, random);
    for (BodyBond& bond : network.bonds) bond.bars = bond.bars < 3 ? 6 : 5;
    network.lock_leaves = round % 2 == 0;
    const Rigidity rigidity = analyse_rigidity(network);
    int freedom = 0;
    std::size_t hinges = 0;
    for (const HingeGroup& group : hinge_groups(network, rigidity)) {
      freedom += group.freedom;
      hinges += group.hinges.size();
    }
    // a leaf's spin is in no group, and hinges between the same two bodies may lie in different
    // ways
    ASSERT_EQ(freedom, rigidity.floppy_modes) << round;
    ASSERT_EQ(hinges, rigidity.hinges.size()) << round;
  }
}

TEST(HingeGroups, ThoseWithMoreFreedomComeFirst) {
  BodyBarNetwork network = ring_of(9, 5);
  network.bodies = 11;
  network.bonds.insert(network.bonds.begin(), {{0, 9, 5}, {9, 10, 5}});
  const std::vector<HingeGroup> groups = groups_of(network);
  ASSERT_EQ(groups.size(), 3U);
  EXPECT_EQ(groups[0].freedom, 3);
  EXPECT_EQ(groups[1].hinges, std::vector<int>{0});
  EXPECT_EQ(groups[2].hinges, std::vector<int>{1});
}

}  // namespace
}  // namespace ragdoll
