// Tests for core/src/statistics.cpp.

#include <gtest/gtest.h>

#include <algorithm>  // min_element

#include "examples.h"  // refusal_of
#include "ragdoll/random.h"
#include "ragdoll/statistics.h"

namespace ragdoll {
namespace {

using Values = std::vector<std::int64_t>;

TEST(Statistics, MeanAndDeviationAreThoseOfThePopulation) {
  const Statistics s = statistics_of(Values{2, 4, 4, 4, 5, 5, 7, 9});
  EXPECT_EQ(s.count, 8);
  EXPECT_DOUBLE_EQ(s.mean, 5);
  EXPECT_DOUBLE_EQ(s.deviation, 2);
  EXPECT_EQ(s.least, 2);
  EXPECT_EQ(s.most, 9);
}

TEST(Statistics, ModeIsTheSmallestOfThoseThatOccurMostOften) {
  EXPECT_EQ(statistics_of(Values{7, 3, 7, 3, 1}).mode, 3);
  EXPECT_EQ(statistics_of(Values{5, 4, 3}).mode, 3);
  EXPECT_EQ(statistics_of(Values{1, 8, 8}).mode, 8);
}

TEST(Statistics, OneValueHasNoDeviation) {
  const Statistics s = statistics_of(Values{42});
  EXPECT_EQ(s.mean, 42);
  EXPECT_EQ(s.deviation, 0);
  EXPECT_EQ(s.p50, 42);
  EXPECT_EQ(s.p99, 42);
}

TEST(Statistics, PercentilesAreNearestRanks) {
  Values hundred;
  for (int k = 100; k > 0; --k) hundred.push_back(k);
  EXPECT_EQ(percentile(hundred, 50), 50);
  EXPECT_EQ(percentile(hundred, 99), 99);
  EXPECT_EQ(percentile(hundred, 99.5), 100);
  EXPECT_EQ(percentile(hundred, 0), 1);
  EXPECT_EQ(percentile(hundred, 100), 100);
  EXPECT_EQ(percentile(Values{15, 20, 35, 40, 50}, 40), 20);
  EXPECT_EQ(percentile(Values{1, 2}, 50), 1);
}

TEST(Statistics, AtLeastThePercentageOfValuesIsNotAboveThePercentile) {
  Random random(1, RandomStream::generate, 0);
  for (int repeat = 0; repeat < 200; ++repeat) {
    Values values(1 + random.below(50));
    for (std::int64_t& value : values) value = std::int64_t(random.below(10));
    const double percent = double(random.below(101));
    const std::int64_t p = percentile(values, percent);
    double not_above = 0, below = 0;
    for (const std::int64_t value : values) {
      not_above += value <= p;
      below += value < p;
    }
    EXPECT_GE(not_above * 100, percent * double(values.size()));
    // a smaller value would not do
    if (p > *std::min_element(values.begin(), values.end())) {
      EXPECT_LT(below * 100, percent * double(values.size()));
    }
  }
}

TEST(Statistics, OrderOfTheValuesDoesNotShowInTheLastBit) {
  Random random(2, RandomStream::generate, 0);
  Values values(1000);
  for (std::int64_t& value : values) value = std::int64_t(random.below(1'000'000'000'000));
  const Statistics first = statistics_of(values);
  for (std::size_t k = values.size(); k > 1; --k) std::swap(values[k - 1], values[random.below(k)]);
  const Statistics second = statistics_of(values);
  EXPECT_EQ(first.mean, second.mean);
  EXPECT_EQ(first.deviation, second.deviation);
}

TEST(Statistics, HistogramCountsEachValueInAscendingOrder) {
  const std::vector<std::pair<std::int64_t, std::int64_t>> expected = {{-1, 1}, {3, 2}, {5, 3}};
  EXPECT_EQ(histogram_of(Values{5, 3, 5, -1, 3, 5}), expected);
  EXPECT_TRUE(histogram_of(Values{}).empty());
}

TEST(Statistics, NoValuesAreRefused) {
  EXPECT_EQ(examples::refusal_of([] { statistics_of(Values{}); }),
            "there are no values to take statistics of");
  EXPECT_EQ(examples::refusal_of([] { percentile(Values{}, 50); }),
            "there are no values to take a percentile of");
  EXPECT_EQ(examples::refusal_of([] { percentile(Values{1}, 101); }),
            "a percentile lies between 0 and 100");
}

}  // namespace
}  // namespace ragdoll
