// Statistics of counts, as the thesis reports them, and what a mode hides: the tail.

#pragma once
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace ragdoll {

struct Statistics {
  std::int64_t count = 0;
  double mean = 0;
  double deviation = 0;           ///< of the population: divided by count, not count - 1
  std::int64_t mode = 0;          ///< the smallest of them on ties
  std::int64_t p50 = 0, p99 = 0;  ///< by nearest rank, see percentile()
  std::int64_t least = 0, most = 0;
};

/// The same for any order of the values, to the last bit.
/// @throw Error if there are no values
Statistics statistics_of(std::span<const std::int64_t> values);

/// Nearest rank: the smallest value that at least `percent` of all values do not exceed.
/// @param percent  0 (the least) to 100 (the most)
/// @throw Error if there are no values, or the percentage is out of range
std::int64_t percentile(std::span<const std::int64_t> values, double percent);

/// Each value that occurs, ascending, and how often.
std::vector<std::pair<std::int64_t, std::int64_t>> histogram_of(
    std::span<const std::int64_t> values);

}  // namespace ragdoll
