// Max tree: numbers, and the largest of them. Changing one costs no more than the log of their
// count, and most often one or two steps. Private to the resolvers.

#pragma once
#include <algorithm>  // max
#include <bit>        // bit_ceil
#include <cstddef>
#include <vector>

namespace ragdoll {

class MaxTree {
 public:
  explicit MaxTree(std::size_t count)
      : leaves_(std::bit_ceil(std::max<std::size_t>(count, 1))), value_(2 * leaves_, 0.0) {}

  double largest() const { return value_[1]; }

  void set(std::size_t index, double value) {
    std::size_t k = leaves_ + index;
    value_[k] = value;
    while (k > 1) {
      k /= 2;
      const double larger = std::max(value_[2 * k], value_[2 * k + 1]);
      if (value_[k] == larger) return;
      value_[k] = larger;
    }
  }

 private:
  std::size_t leaves_;
  std::vector<double> value_;  ///< 1 is the root, 2k and 2k + 1 are k's; leaves last
};

}  // namespace ragdoll
