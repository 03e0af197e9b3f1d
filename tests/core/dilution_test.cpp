// Tests for core/src/dilution.cpp.

#include "ragdoll/dilution.h"

#include <gtest/gtest.h>

#include "body_bar_examples.h"
#include "examples.h"

namespace ragdoll {
namespace {

using namespace examples;

void expect_equal(const Rigidity& one, const Rigidity& other) {
  EXPECT_EQ(one.degrees_of_freedom, other.degrees_of_freedom);
  EXPECT_EQ(one.floppy_modes, other.floppy_modes);
  EXPECT_EQ(one.separate_bodies, other.separate_bodies);
  EXPECT_EQ(one.redundant_bars, other.redundant_bars);
  EXPECT_EQ(one.cluster_of_body, other.cluster_of_body);
  EXPECT_EQ(one.cluster_sizes, other.cluster_sizes);
  EXPECT_EQ(one.region_of_body, other.region_of_body);
  EXPECT_EQ(one.region_sizes, other.region_sizes);
  EXPECT_EQ(one.hinges, other.hinges);
}

TEST(Dilution, EveryLevelIsWhatItsBondsAloneGive) {
  Random random(3, RandomStream::generate, 0);
  for (int round = 0; round < 60; ++round) {
    const int bodies = 5 + int(random.below(40));
    BodyBarNetwork network = random_network(bodies, 2 * bodies, random);
    network.lock_leaves = round % 2 == 0;
    const int fixed = int(random.below(std::uint64_t(bodies)));
    const Dilution dilution(network, fixed);
    ASSERT_EQ(dilution.level_count(), int(network.bonds.size()) - fixed + 1);
    BodyBarNetwork present = network;
    for (int level = 0; level < dilution.level_count(); ++level) {
      present.bonds.assign(network.bonds.begin(), network.bonds.begin() + fixed + level);
      expect_equal(dilution.at(level), analyse_rigidity(present));
      if (::testing::Test::HasFailure()) FAIL() << "round " << round << ", level " << level;
    }
  }
}

TEST(Dilution, AHydrogenBondFreesTheSpinsOfTheLeavesThatItJoins) {
  // two chains of three whose ends are bonded at the next level
  const BodyBarNetwork network = {6, {{0, 1, 5}, {1, 2, 5}, {3, 4, 5}, {4, 5, 5}, {2, 3, 5}}};
  const Dilution dilution(network, 4);
  const Rigidity before = dilution.at(0), after = dilution.at(1);
  EXPECT_EQ(before.floppy_modes, 0);
  EXPECT_EQ(before.degrees_of_freedom, 12);
  EXPECT_EQ(before.cluster_sizes, (std::vector<int>{3, 3}));
  EXPECT_EQ(after.floppy_modes, 3);
  EXPECT_EQ(after.degrees_of_freedom, 9);
  EXPECT_EQ(after.cluster_sizes, (std::vector<int>{2, 2, 1, 1}));
  EXPECT_EQ(after.hinges, (std::vector<int>{1, 2, 4}));
}

TEST(Dilution, ABondThatClosesARingMakesRigidWhatHangsOnItByAllItsBars) {
  // bodies 6 and 7 are joined to the ring and to each other in a way that is rigid only when the
  // ring is: the bond that closes the ring does not touch them
  BodyBarNetwork network = chain_of(6, 5);
  network.bodies = 8;
  network.bonds.push_back({6, 7, 6});
  network.bonds.push_back({6, 1, 3});
  network.bonds.push_back({7, 4, 3});
  network.bonds.push_back({5, 0, 5});
  const Dilution dilution(network, int(network.bonds.size()) - 1);
  EXPECT_EQ(dilution.at(0).cluster_sizes.front(), 2);
  EXPECT_EQ(dilution.at(1).cluster_sizes, std::vector<int>{8});
}

TEST(Dilution, ItCostsLittleMoreThanItsLastLevelAlone) {
  Random random(4, RandomStream::generate, 0);
  BodyBarNetwork network = random_network(3000, 3600, random);
  const long all = Dilution(network, 0).visits();
  const long alone = Dilution(network, int(network.bonds.size())).visits();
  EXPECT_LT(all, 30 * alone);
}

TEST(Dilution, LevelsAndNumbersOfBondsThatThereAreNotAreRefused) {
  const BodyBarNetwork network = chain_of(3, 5);
  EXPECT_EQ(refusal_of([&] { Dilution(network, 3); }),
            "the network has 2 bonds, of which 3 cannot be fixed");
  EXPECT_EQ(refusal_of([&] { Dilution(network, -1); }),
            "the network has 2 bonds, of which -1 cannot be fixed");
  const Dilution dilution(network, 1);
  for (const int level : {-1, 2})
    EXPECT_EQ(refusal_of([&] { dilution.at(level); }),
              "the dilution has levels 0 to 1, not " + std::to_string(level));
}

}  // namespace
}  // namespace ragdoll
