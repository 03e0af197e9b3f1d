// Tests for core/src/cell_list.cpp, and of minimum images.

#include "ragdoll/cell_list.h"

#include <gtest/gtest.h>

#include <algorithm>  // sort, min
#include <utility>    // pair

#include "contact_examples.h"
#include "vector_targets.h"

namespace ragdoll {
namespace {

using namespace examples;

using Pairs = std::vector<std::pair<int, int>>;

std::vector<CellPair> candidates_of(const Positions& x, double cutoff, const Box* box) {
  const CellList cells(x, cutoff, box);
  std::vector<CellPair> pairs;
  for (std::size_t cell = 0; cell < cells.cell_count(); ++cell) cells.find_candidates(cell, pairs);
  return pairs;
}

/// The candidates below the cutoff, sorted.
Pairs pairs_of(const Positions& x, double cutoff, const Box* box) {
  Pairs pairs;
  for (const CellPair& pair : candidates_of(x, cutoff, box)) {
    const double distance = distance_of(x, pair.p, pair.q, box);
    EXPECT_LT(pair.p, pair.q);
    EXPECT_LE(double(pair.distance), distance);
    if (distance < cutoff) pairs.emplace_back(pair.p, pair.q);
  }
  std::sort(pairs.begin(), pairs.end());
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
  EXPECT_FALSE(expected.empty());
  for_each_vector_target([&] { EXPECT_EQ(pairs_of(x, cutoff, box), expected); });
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
  EXPECT_EQ(pairs_of(x, 0.5, nullptr), (Pairs{{1, 2}}));
}

TEST(CellList, NoJointsHaveNoPairs) {
  EXPECT_TRUE(pairs_of(Positions{}, 1, nullptr).empty());
  EXPECT_TRUE(pairs_of(Positions(1, Vec3::Zero()), 1, nullptr).empty());
}

TEST(CellList, FindsThePairsOfJointsThatAreAllInOneCell) {
  Random random = dice(14);
  expect_all_pairs(random_points(200, 0.1, random), 0.15, nullptr);
  expect_all_pairs(Positions(70, Vec3(1, 2, 3)), 0.15, nullptr);
}

TEST(CellList, CandidatesBeyondTheCutoffAreFew) {
  Random random = dice(15);
  const Box box = dodecahedron(3);
  for (const Box* where : {static_cast<const Box*>(nullptr), &box}) {
    const Positions x = random_points(400, 2, random);
    for_each_vector_target([&] {
      EXPECT_LE(candidates_of(x, 0.6, where).size(), brute_force(x, 0.601, where).size());
    });
  }
}

}  // namespace
}  // namespace ragdoll
