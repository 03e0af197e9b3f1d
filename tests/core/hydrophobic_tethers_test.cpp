// Tests for core/src/hydrophobic_tethers.cpp.

#include "ragdoll/hydrophobic_tethers.h"

#include <gtest/gtest.h>

#include <limits>

#include "examples.h"
#include "molecules.h"

namespace ragdoll {
namespace {

using namespace examples;

/// Two atoms of given elements so far apart, the second with another atom on it.
std::vector<HydrophobicTether> between(int one, int other, double distance, int on_other = 1) {
  return hydrophobic_tethers(Molecule({{one, 0, 1}, {other, 0, 1}, {on_other, 0, 1}}, {{1, 2}},
                                      {Vec3::Zero(), {distance, 0, 0}, {distance + 0.11, 0, 0}}));
}

TEST(HydrophobicTethers, TheyReachHalfAnAngstromBeyondTheRadii) {
  EXPECT_EQ(between(6, 6, 0.39 - 1e-9).size(), 1U);
  EXPECT_EQ(between(6, 6, 0.39 + 1e-9).size(), 0U);
  EXPECT_EQ(between(6, 16, 0.40 - 1e-9).size(), 1U);
  EXPECT_EQ(between(6, 16, 0.40 + 1e-9).size(), 0U);
  EXPECT_EQ(between(16, 16, 0.41 - 1e-9).size(), 1U);
  EXPECT_EQ(between(16, 16, 0.41 + 1e-9).size(), 0U);
  const auto tethers = between(6, 16, 0.38);
  ASSERT_EQ(tethers.size(), 1U);
  EXPECT_EQ(tethers[0].a, 0);
  EXPECT_EQ(tethers[0].b, 1);
  EXPECT_DOUBLE_EQ(tethers[0].distance, 0.38);
  EXPECT_DOUBLE_EQ(tethers[0].bound, 0.40);
}

TEST(HydrophobicTethers, PairsThatAlmostCoincideHaveNone) {
  EXPECT_EQ(between(6, 6, 0.2199).size(), 0U);
  EXPECT_EQ(between(6, 6, 0.2201).size(), 1U);
}

TEST(HydrophobicTethers, PolarNeighboursMakeAnAtomPolar) {
  for (const int element : {1, 6, 16}) EXPECT_EQ(between(6, 6, 0.37, element).size(), 1U);
  for (const int element : {7, 8, 9, 15, 17, 30})
    EXPECT_EQ(between(6, 6, 0.37, element).size(), 0U);
  for (const int element : {1, 7, 8, 30}) EXPECT_EQ(between(6, element, 0.37).size(), 0U);
}

TEST(HydrophobicTethers, AtomsUpToThreeBondsApartHaveNone) {
  // a zigzag of carbons, its atoms i and i + k being close for every k
  const int n = 6;
  std::vector<Atom> atoms;
  std::vector<Bond> bonds;
  Positions x;
  for (int k = 0; k < n; ++k) {
    atoms.push_back({6, 0, 12});
    if (k > 0) bonds.push_back({k - 1, k});
    x.push_back({0.06 * k, k % 2 == 0 ? 0 : 0.24, 0});
  }
  std::vector<std::pair<int, int>> pairs;
  for (const HydrophobicTether& tether : hydrophobic_tethers(Molecule(atoms, bonds, x)))
    pairs.emplace_back(tether.a, tether.b);
  EXPECT_EQ(pairs, (std::vector<std::pair<int, int>>{{0, 4}, {0, 5}, {1, 5}}));
}

TEST(HydrophobicTethers, ThoseOfManyAtomsAreThoseOfEveryPair) {
  Random random(7, RandomStream::generate, 0);
  const Positions x = random_points(400, 2.5, random);
  std::vector<int> elements;
  for (std::size_t k = 0; k < x.size(); ++k) elements.push_back(k % 5 == 0 ? 16 : 6);
  const auto tethers = hydrophobic_tethers(loose_atoms(elements, x));
  std::size_t next = 0;
  for (int a = 0; a < 400; ++a)
    for (int b = a + 1; b < 400; ++b) {
      const auto radius = [&](int i) { return elements[std::size_t(i)] == 16 ? 0.18 : 0.17; };
      const double distance = (x[std::size_t(a)] - x[std::size_t(b)]).norm();
      if (distance < 0.22 || distance > radius(a) + radius(b) + 0.05) continue;
      ASSERT_LT(next, tethers.size());
      EXPECT_EQ(tethers[next].a, a);
      EXPECT_EQ(tethers[next].b, b);
      ++next;
    }
  EXPECT_EQ(next, tethers.size());
  EXPECT_GT(next, 100U);
}

TEST(HydrophobicTethers, OptionsThatAreNoNumbersAreRefused) {
  const Molecule one = loose_atoms({6}, {Vec3::Zero()});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const HydrophobicTetherOptions& options :
       {HydrophobicTetherOptions{nan, 0.22}, HydrophobicTetherOptions{0.05, nan}})
    EXPECT_EQ(refusal_of([&] { hydrophobic_tethers(one, options); }),
              "the margin and the shortest length of tethers are to be numbers");
}

}  // namespace
}  // namespace ragdoll
