#include "ragdoll/statistics.h"

#include <algorithm>  // sort, clamp
#include <cmath>      // ceil, sqrt

#include "ragdoll/error.h"  // Error

namespace ragdoll {
namespace {

std::vector<std::int64_t> sorted(std::span<const std::int64_t> values) {
  std::vector<std::int64_t> copy(values.begin(), values.end());
  std::sort(copy.begin(), copy.end());
  return copy;
}

std::int64_t nearest_rank(const std::vector<std::int64_t>& ascending, double percent) {
  if (ascending.empty()) throw Error("there are no values to take a percentile of");
  if (!(percent >= 0 && percent <= 100)) throw Error("a percentile lies between 0 and 100");
  const double n = double(ascending.size());
  // percent * n first: 99 % of 100 is exactly 99
  const double rank = std::clamp(std::ceil(percent * n / 100), 1.0, n);
  return ascending[std::size_t(rank) - 1];
}

}  // namespace

std::vector<std::pair<std::int64_t, std::int64_t>> histogram_of(
    std::span<const std::int64_t> values) {
  std::vector<std::pair<std::int64_t, std::int64_t>> bins;
  for (const std::int64_t value : sorted(values)) {
    if (bins.empty() || bins.back().first != value) bins.emplace_back(value, 0);
    ++bins.back().second;
  }
  return bins;
}

std::int64_t percentile(std::span<const std::int64_t> values, double percent) {
  return nearest_rank(sorted(values), percent);
}

Statistics statistics_of(std::span<const std::int64_t> values) {
  if (values.empty()) throw Error("there are no values to take statistics of");
  const std::vector<std::int64_t> ascending = sorted(values);
  const double n = double(ascending.size());
  Statistics s;
  s.count = std::int64_t(ascending.size());
  s.least = ascending.front();
  s.most = ascending.back();
  s.p50 = nearest_rank(ascending, 50);
  s.p99 = nearest_rank(ascending, 99);

  // mean and deviation in ascending order, so that the order of the runs does not show
  double sum = 0, squares = 0;
  for (const std::int64_t value : ascending) sum += double(value);
  s.mean = sum / n;
  for (const std::int64_t value : ascending)
    squares += (double(value) - s.mean) * (double(value) - s.mean);
  s.deviation = std::sqrt(squares / n);

  std::int64_t most_often = 0;
  for (const auto& [value, count] : histogram_of(values)) {
    if (count <= most_often) continue;
    most_often = count;
    s.mode = value;
  }
  return s;
}

}  // namespace ragdoll
