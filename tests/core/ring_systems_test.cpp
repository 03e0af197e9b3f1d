// Tests for core/src/ring_systems.cpp.

#include "ragdoll/ring_systems.h"

#include <gtest/gtest.h>

#include "molecules.h"

namespace ragdoll {
namespace {

/// Carbons at any places, bonded as told.
Molecule skeleton(int atoms, const std::vector<Bond>& bonds) {
  std::vector<Atom> all(std::size_t(atoms), Atom{6, 0, 12.011, {}});
  std::vector<Vec3> x;
  for (int k = 0; k < atoms; ++k) x.push_back(0.15 * Vec3(k % 5, k / 5, 0.3 * k));
  return Molecule(all, bonds, x);
}

std::vector<Bond> ring_bonds(int first, int count) {
  std::vector<Bond> bonds;
  for (int k = 0; k < count; ++k)
    bonds.push_back({first + k, first + (k + 1) % count, BondOrder::single});
  return bonds;
}

TEST(RingSystems, AChainHasNone) {
  EXPECT_TRUE(ring_systems(examples::heptane()).empty());
}

TEST(RingSystems, BenzeneIsOneRingOfSixAndItsHydrogensAreOutside) {
  const std::vector<RingSystem> systems = ring_systems(examples::benzene());
  ASSERT_EQ(systems.size(), 1U);
  EXPECT_EQ(systems[0].atoms, (std::vector<int>{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(systems[0].bonds, (std::vector<int>{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(systems[0].ring_size, std::vector<int>(6, 6));
}

TEST(RingSystems, RingsThatABondJoinsAreTwo) {
  std::vector<Bond> bonds = ring_bonds(0, 5);
  const std::vector<Bond> other = ring_bonds(5, 6);
  bonds.insert(bonds.end(), other.begin(), other.end());
  bonds.push_back({0, 5, BondOrder::single});
  const std::vector<RingSystem> systems = ring_systems(skeleton(11, bonds));
  ASSERT_EQ(systems.size(), 2U);
  EXPECT_EQ(systems[0].largest_ring(), 5);
  EXPECT_EQ(systems[1].largest_ring(), 6);
}

TEST(RingSystems, SpiroRingsAreOneSystem) {
  std::vector<Bond> bonds = ring_bonds(0, 5);
  for (const auto& [a, b] : {std::pair(0, 5), {5, 6}, {6, 7}, {7, 0}})
    bonds.push_back({a, b, BondOrder::single});
  const std::vector<RingSystem> systems = ring_systems(skeleton(8, bonds));
  ASSERT_EQ(systems.size(), 1U);
  EXPECT_EQ(systems[0].atoms.size(), 8U);
  EXPECT_EQ(systems[0].largest_ring(), 5);
}

TEST(RingSystems, TheBondThatFusedRingsShareHasTheSmallerRingsSize) {
  std::vector<Bond> bonds = ring_bonds(0, 6);
  for (const auto& [a, b] : {std::pair(0, 6), {6, 7}, {7, 8}, {8, 9}, {9, 10}, {10, 1}})
    bonds.push_back({a, b, BondOrder::single});
  const std::vector<RingSystem> systems = ring_systems(skeleton(11, bonds));
  ASSERT_EQ(systems.size(), 1U);
  EXPECT_EQ(systems[0].ring_size[0], 6);
  EXPECT_EQ(systems[0].ring_size[6], 7);
  EXPECT_EQ(systems[0].largest_ring(), 7);
}

TEST(RingSystems, DativeBondsCloseNoRings) {
  std::vector<Bond> bonds = ring_bonds(0, 5);
  bonds[2].order = BondOrder::dative;
  EXPECT_TRUE(ring_systems(skeleton(5, bonds)).empty());
}

TEST(RingSystems, ARingOfThousandsOfAtomsIsFound) {
  const std::vector<RingSystem> systems = ring_systems(skeleton(3000, ring_bonds(0, 3000)));
  ASSERT_EQ(systems.size(), 1U);
  EXPECT_EQ(systems[0].atoms.size(), 3000U);
}

}  // namespace
}  // namespace ragdoll
