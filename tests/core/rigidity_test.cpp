// Tests for core/src/rigidity.cpp, pebble_game.cpp and disjoint_sets.h.

#include "ragdoll/rigidity.h"

#include <gtest/gtest.h>

#include <algorithm>  // shuffle
#include <numeric>    // iota, accumulate

#include "body_bar_examples.h"
#include "examples.h"
#include "ragdoll/dilution.h"

namespace ragdoll {
namespace {

using namespace examples;

std::vector<int> count_to(int n) {
  std::vector<int> numbers(static_cast<std::size_t>(n));
  std::iota(numbers.begin(), numbers.end(), 0);
  return numbers;
}

TEST(Rigidity, OneBodyHasSixFreedomsAndNoFloppyMode) {
  const Rigidity r = analyse_rigidity({1, {}});
  EXPECT_EQ(r.degrees_of_freedom, 6);
  EXPECT_EQ(r.floppy_modes, 0);
  EXPECT_EQ(r.separate_bodies, 1);
  EXPECT_EQ(r.redundant_bars, 0);
  EXPECT_EQ(r.cluster_of_body, std::vector<int>{0});
  EXPECT_EQ(r.region_of_body, std::vector<int>{-1});
  EXPECT_TRUE(r.hinges.empty());
}

TEST(Rigidity, EachBondOfAChainLeavesWhatItsBarsDoNotTake) {
  for (int bars = 1; bars <= 6; ++bars) {
    const Rigidity r = analyse_rigidity(chain_of(5, bars));
    EXPECT_EQ(r.floppy_modes, 4 * (6 - bars));
    EXPECT_EQ(r.separate_bodies, 1);
    EXPECT_EQ(r.redundant_bars, 0);
    EXPECT_EQ(r.cluster_sizes.size(), bars == 6 ? 1U : 5U);
    EXPECT_EQ(r.hinges, bars == 5 ? count_to(4) : std::vector<int>{});
  }
}

TEST(Rigidity, ARingOfNHingesTurnsByNLessSix) {
  for (int n = 3; n <= 12; ++n) {
    const Rigidity r = analyse_rigidity(ring_of(n, 5));
    EXPECT_EQ(r.floppy_modes, std::max(0, n - 6)) << n;
    EXPECT_EQ(r.redundant_bars, std::max(0, 6 - n)) << n;
    EXPECT_EQ(r.cluster_sizes.size(), n <= 6 ? 1U : std::size_t(n)) << n;
    EXPECT_EQ(r.region_sizes, n < 6 ? std::vector<int>{n} : std::vector<int>{}) << n;
    EXPECT_EQ(r.hinges, n <= 6 ? std::vector<int>{} : count_to(n)) << n;
  }
}

TEST(Rigidity, RingsThatShareABondAreRigidTogether) {
  // decalin: ten bodies, eleven hinges; a ring of six and one of seven: eleven bodies, twelve
  BodyBarNetwork decalin = ring_of(10, 5);
  decalin.bonds.push_back({0, 5, 5});
  const Rigidity two_sixes = analyse_rigidity(decalin);
  EXPECT_EQ(two_sixes.floppy_modes, 0);
  EXPECT_EQ(two_sixes.redundant_bars, 1);
  EXPECT_EQ(two_sixes.cluster_sizes, std::vector<int>{10});
  EXPECT_EQ(two_sixes.region_sizes, std::vector<int>{10});

  BodyBarNetwork fused = ring_of(11, 5);
  fused.bonds.push_back({0, 5, 5});
  const Rigidity six_and_seven = analyse_rigidity(fused);
  EXPECT_EQ(six_and_seven.floppy_modes, 0);
  EXPECT_EQ(six_and_seven.redundant_bars, 0);
  EXPECT_EQ(six_and_seven.cluster_sizes, std::vector<int>{11});
  EXPECT_TRUE(six_and_seven.region_sizes.empty());
}

TEST(Rigidity, WhatHangsOnAnOverConstrainedRingIsNotOverConstrained) {
  BodyBarNetwork network = ring_of(4, 5);
  network.bodies = 7;
  network.bonds.push_back({3, 4, 6});  // rigid with the ring
  network.bonds.push_back({4, 5, 5});  // turns
  const Rigidity r = analyse_rigidity(network);
  EXPECT_EQ(r.redundant_bars, 2);
  EXPECT_EQ(r.cluster_of_body, (std::vector<int>{0, 0, 0, 0, 0, 1, 2}));
  EXPECT_EQ(r.region_of_body, (std::vector<int>{0, 0, 0, 0, -1, -1, -1}));
  EXPECT_EQ(r.hinges, std::vector<int>{5});
  EXPECT_EQ(r.separate_bodies, 2);
  EXPECT_EQ(r.degrees_of_freedom, 13);
  EXPECT_EQ(r.floppy_modes, 1);
}

TEST(Rigidity, ALeafDoesNotSpinUnlessItIsToldTo) {
  // a chain of four: its end bonds are those of leaves
  BodyBarNetwork network = chain_of(4, 5);
  EXPECT_EQ(analyse_rigidity(network).floppy_modes, 3);
  network.lock_leaves = true;
  const Rigidity r = analyse_rigidity(network);
  EXPECT_EQ(r.floppy_modes, 1);
  EXPECT_EQ(r.cluster_of_body, (std::vector<int>{0, 0, 1, 1}));
  EXPECT_EQ(r.hinges, std::vector<int>{1});
  EXPECT_EQ(analyse_rigidity({2, {{0, 1, 5}}}).floppy_modes, 0);
}

TEST(Rigidity, ATetherAtALeafMakesItNoLeafAndATetherIsNoLeafsBond) {
  BodyBarNetwork network = {5, {{0, 1, 5}, {1, 2, 5}, {2, 3, 5}, {3, 4, 2}}};
  const Rigidity r = analyse_rigidity(network);
  // the first bond is a leaf's; 3 has a tether; 4 has only a tether, which keeps its two bars
  EXPECT_EQ(r.floppy_modes, 1 + 1 + 4);
  EXPECT_EQ(r.cluster_of_body, (std::vector<int>{0, 0, 1, 2, 3}));
}

TEST(Rigidity, RandomNetworksAgreeWithTheRankOfTheirRigidityMatrix) {
  Random random(1, RandomStream::generate, 0);
  int floppy = 0, stressed = 0, mixed = 0;
  for (int round = 0; round < 300; ++round) {
    const int bodies = 2 + int(random.below(8));
    const int bonds = 1 + int(random.below(std::uint64_t(2 * bodies)));
    const BodyBarNetwork network = random_network(bodies, bonds, random);
    const RigidityMatrix matrix(network, random);
    const Rigidity r = analyse_rigidity(network);
    ASSERT_EQ(r.degrees_of_freedom, matrix.degrees_of_freedom()) << round;
    ASSERT_EQ(r.redundant_bars, matrix.redundant_bars()) << round;
    ASSERT_EQ(r.cluster_of_body, matrix.cluster_of_body()) << round;
    ASSERT_EQ(r.region_of_body, matrix.region_of_body()) << round;
    floppy += r.floppy_modes > 0;
    stressed += r.redundant_bars > 0;
    mixed += r.cluster_sizes.size() > 1 && r.cluster_sizes[0] > 2;
  }
  // all kinds were met
  EXPECT_GT(floppy, 50);
  EXPECT_GT(stressed, 50);
  EXPECT_GT(mixed, 30);
}

TEST(Rigidity, TheOrderOfBondsDoesNotMatter) {
  Random random(2, RandomStream::generate, 0);
  for (int round = 0; round < 50; ++round) {
    BodyBarNetwork network = random_network(40, 60, random);
    network.lock_leaves = true;
    const Rigidity one = analyse_rigidity(network);
    for (std::size_t k = network.bonds.size(); k > 1; --k)
      std::swap(network.bonds[k - 1], network.bonds[random.below(k)]);
    const Rigidity other = analyse_rigidity(network);
    ASSERT_EQ(one.degrees_of_freedom, other.degrees_of_freedom);
    ASSERT_EQ(one.redundant_bars, other.redundant_bars);
    ASSERT_EQ(one.cluster_of_body, other.cluster_of_body);
    ASSERT_EQ(one.region_of_body, other.region_of_body);
    ASSERT_EQ(one.hinges.size(), other.hinges.size());
  }
}

/// A strip of rings of six, every fourth joined to the next by a bond more: rigid pieces and
/// hinges.
BodyBarNetwork strip_of(int rings) {
  BodyBarNetwork network{6 * rings, {}, true};
  for (int r = 0; r < rings; ++r) {
    for (int k = 0; k < 6; ++k) network.bonds.push_back({6 * r + k, 6 * r + (k + 1) % 6, 5});
    if (r + 1 < rings) network.bonds.push_back({6 * r + 3, 6 * r + 6, 5});
    if (r + 1 < rings && r % 4 < 2) network.bonds.push_back({6 * r + 4, 6 * r + 7, 5});
  }
  return network;
}

TEST(Rigidity, TheCostGrowsNearlyAsTheNumberOfBonds) {
  const auto visits = [](const BodyBarNetwork& network) {
    return double(Dilution(network, int(network.bonds.size())).visits());
  };
  EXPECT_LT(visits(strip_of(10000)), 1.2 * 10 * visits(strip_of(1000)));
  // one long chain closed to a ring: searches go all the way round only a few times
  EXPECT_LT(visits(ring_of(20000, 5)), 1.2 * 10 * visits(ring_of(2000, 5)));
}

TEST(Rigidity, NetworksThatMakeNoSenseAreRefused) {
  const auto refusal = [](const BodyBarNetwork& network) {
    return refusal_of([&] { analyse_rigidity(network); });
  };
  EXPECT_EQ(refusal({0, {}}), "the network has no bodies");
  EXPECT_EQ(refusal({2, {{0, 1, 5}, {0, 2, 5}}}),
            "bond 1 of the network names a body that there is not");
  EXPECT_EQ(refusal({2, {{-1, 1, 5}}}), "bond 0 of the network names a body that there is not");
  EXPECT_EQ(refusal({2, {{1, 1, 5}}}), "bond 0 of the network joins body 1 to itself");
  for (const int bars : {0, 7})
    EXPECT_EQ(refusal({2, {{0, 1, bars}}}),
              "bond 0 of the network has " + std::to_string(bars) + " bars instead of 1 to 6");
}

}  // namespace
}  // namespace ragdoll
