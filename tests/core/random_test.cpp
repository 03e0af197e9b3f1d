// Tests for core/src/random.cpp.

#include "ragdoll/random.h"

#include <gtest/gtest.h>

#include <cmath>  // abs, pow
#include <set>

namespace ragdoll {
namespace {

TEST(Random, OneAddressGivesTheSameNumbers) {
  Random one(5, RandomStream::order, 9), other(5, RandomStream::order, 9);
  for (int k = 0; k < 100; ++k) EXPECT_EQ(one.next(), other.next());
}

TEST(Random, NumbersAreThoseOfThePublishedGenerator) {
  // xoshiro256++ seeded through splitmix64, computed apart from this library
  Random random(42, RandomStream::perturbation, 7);
  EXPECT_EQ(random.next(), 0x44304ccee5a9f062u);
  EXPECT_EQ(random.next(), 0xaafbff35a5f646b8u);
  EXPECT_EQ(random.next(), 0xace12d171188a486u);
}

TEST(Random, NeighbouringAddressesShareNoNumbers) {
  std::set<std::uint64_t> seen;
  int drawn = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed)
    for (const auto stream :
         {RandomStream::perturbation, RandomStream::order, RandomStream::generate})
      for (std::uint64_t step = 0; step < 10; ++step) {
        Random random(seed, stream, step);
        for (int k = 0; k < 10; ++k, ++drawn) seen.insert(random.next());
      }
  EXPECT_EQ(int(seen.size()), drawn);
}

TEST(Random, FirstNumbersOfSuccessiveStepsAreUniform) {
  // streams are addressed anew in each step, so their first numbers must be as good as a stream
  double sum = 0, squares = 0, products = 0, last = 0.5;
  constexpr int n = 20000;
  for (int step = 0; step < n; ++step) {
    const double u = Random(1, RandomStream::order, std::uint64_t(step)).uniform();
    sum += u;
    squares += u * u;
    products += (u - 0.5) * (last - 0.5);
    last = u;
  }
  EXPECT_NEAR(sum / n, 0.5, 0.011);  // five deviations
  EXPECT_NEAR(squares / n, 1.0 / 3, 0.011);
  EXPECT_NEAR(products / n, 0, 0.003);
}

TEST(Random, UniformNumbersFillTheUnitIntervalEvenly) {
  Random random(2, RandomStream::generate, 0);
  int bins[10] = {};
  for (int k = 0; k < 100000; ++k) {
    const double u = random.uniform();
    ASSERT_GE(u, 0);
    ASSERT_LT(u, 1);
    ++bins[int(10 * u)];
  }
  for (const int bin : bins) EXPECT_NEAR(bin, 10000, 480);
}

TEST(Random, WholeNumbersBelowABoundAreEquallyLikely) {
  Random random(3, RandomStream::generate, 0);
  int counts[7] = {};
  for (int k = 0; k < 70000; ++k) {
    const std::uint64_t value = random.below(7);
    ASSERT_LT(value, 7U);
    ++counts[value];
  }
  for (const int count : counts) EXPECT_NEAR(count, 10000, 470);
  EXPECT_EQ(random.below(1), 0U);
}

TEST(Random, LargeBoundsAreWithoutBias) {
  // of 3/4 of the range: taking remainders would make the lower third twice as likely
  constexpr std::uint64_t bound = 3ull << 62;
  Random random(4, RandomStream::generate, 0);
  int low = 0;
  for (int k = 0; k < 30000; ++k) {
    const std::uint64_t value = random.below(bound);
    ASSERT_LT(value, bound);
    low += value < bound / 3;
  }
  EXPECT_NEAR(low, 10000, 410);
}

TEST(Random, GaussianNumbersHaveTheMomentsOfANormalDistribution) {
  Random random(5, RandomStream::perturbation, 0);
  double moments[5] = {};
  constexpr int n = 200000;
  double pairs = 0, last = 0;
  for (int k = 0; k < n; ++k) {
    const double g = random.gaussian();
    for (int m = 1; m <= 4; ++m) moments[m] += std::pow(g, m) / n;
    pairs += g * last / n;
    last = g;
  }
  EXPECT_NEAR(moments[1], 0, 0.012);
  EXPECT_NEAR(moments[2], 1, 0.016);
  EXPECT_NEAR(moments[3], 0, 0.044);
  EXPECT_NEAR(moments[4], 3, 0.11);
  EXPECT_NEAR(pairs, 0, 0.012);
}

}  // namespace
}  // namespace ragdoll
