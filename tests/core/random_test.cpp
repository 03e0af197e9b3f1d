// Tests for core/src/random.cpp.

#include "ragdoll/random.h"

#include <gtest/gtest.h>

#include <algorithm>  // sort, count_if, max
#include <cmath>      // abs, pow, erfc, sqrt
#include <set>
#include <vector>

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

TEST(Random, RecordsOfAFileHaveSeedsOfTheirOwnThatFitSignedNumbers) {
  std::set<std::uint64_t> seen;
  for (std::uint64_t seed = 0; seed < 20; ++seed)
    for (std::uint64_t record = 0; record < 50; ++record) {
      EXPECT_EQ(record_seed(seed, record),
                record ? Random(seed, RandomStream::record, record).next() / 2 : seed);
      seen.insert(record_seed(seed, record));
    }
  EXPECT_EQ(seen.size(), 1000u);
  EXPECT_LT(*seen.rbegin(), std::uint64_t{1} << 63);
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

// === The ziggurat

std::vector<double> normals(std::size_t count, std::uint64_t seed) {
  std::vector<double> values(count);
  Random(seed, RandomStream::perturbation, 0).fill_normal(values);
  return values;
}

double normal_below(double x) {
  return 0.5 * std::erfc(-x / std::sqrt(2.0));
}

TEST(NormalNumbers, HaveTheMomentsOfANormalDistribution) {
  constexpr int n = 1000000;
  double moments[7] = {}, pairs = 0, last = 0;
  for (const double g : normals(n, 5)) {
    double power = 1;
    for (int m = 1; m <= 6; ++m) moments[m] += (power *= g) / n;
    pairs += g * last / n;
    last = g;
  }
  // within five deviations
  EXPECT_NEAR(moments[1], 0, 0.005);
  EXPECT_NEAR(moments[2], 1, 0.0071);
  EXPECT_NEAR(moments[3], 0, 0.0194);
  EXPECT_NEAR(moments[4], 3, 0.049);
  EXPECT_NEAR(moments[6], 15, 0.51);
  EXPECT_NEAR(pairs, 0, 0.005);
}

TEST(NormalNumbers, AreDistributedNormallyByKolmogorovAndSmirnov) {
  std::vector<double> values = normals(1000000, 6);
  std::sort(values.begin(), values.end());
  const double n = double(values.size());
  double distance = 0;
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double below = normal_below(values[k]);
    distance = std::max({distance, below - double(k) / n, double(k + 1) / n - below});
  }
  EXPECT_LT(distance * std::sqrt(n), 1.95);  // one in a thousand is above that
}

TEST(NormalNumbers, TailsHoldTheirShareOnBothSides) {
  constexpr int n = 4000000;
  const std::vector<double> values = normals(n, 7);
  // 3.654 is where the layers end and the tail is drawn in another way
  for (const double edge : {1.0, 2.0, 3.0, 3.5, 3.6541528853610088, 4.0, 4.5})
    for (const int side : {-1, 1}) {
      const double expected = n * normal_below(-edge);
      const auto beyond =
          std::count_if(values.begin(), values.end(), [&](double x) { return side * x > edge; });
      EXPECT_NEAR(double(beyond), expected, 5 * std::sqrt(expected) + 1) << side * edge;
    }
}

TEST(NormalNumbers, FillTheHistogramEvenlyAcrossTheLayers) {
  // 400 bins of equal share, narrow enough to show an edge of a layer in the wrong place
  constexpr int n = 4000000, bins = 400;
  std::vector<int> counts(bins);
  for (const double x : normals(n, 8)) ++counts[std::size_t(bins * normal_below(x))];
  double chi_squared = 0;
  for (const int count : counts) chi_squared += std::pow(count - n / bins, 2) / (n / bins);
  EXPECT_NEAR(chi_squared, bins - 1, 5 * std::sqrt(2.0 * bins));
}

TEST(NormalNumbers, FillingInPartsGivesTheSameNumbers) {
  const std::vector<double> whole = normals(1000, 9);
  std::vector<double> parts(1000);
  Random random(9, RandomStream::perturbation, 0);
  random.fill_normal(std::span(parts).first(1));
  random.fill_normal(std::span(parts).subspan(1, 600));
  random.fill_normal(std::span(parts).subspan(601));
  EXPECT_EQ(parts, whole);
}

}  // namespace
}  // namespace ragdoll
