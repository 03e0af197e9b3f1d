// Rank set: a set of small numbers in which the next one is found in a few steps, however many
// there could be. Private to the resolvers.

#pragma once
#include <bit>  // countr_zero
#include <cstddef>
#include <cstdint>
#include <vector>

namespace ragdoll {

/// A bit for each number, and a bit for each word of bits that is not zero, and so on.
class RankSet {
 public:
  /// Empties it, for numbers below `size`.
  void resize(std::size_t size) {
    levels_.clear();
    do {
      size = (size + 63) / 64;
      levels_.emplace_back(size, 0);
    } while (size > 1);
  }

  void insert(std::size_t number) {
    for (std::vector<std::uint64_t>& words : levels_) {
      std::uint64_t& word = words[number / 64];
      const bool known = word != 0;
      word |= std::uint64_t(1) << number % 64;
      if (known) return;
      number /= 64;
    }
  }

  void erase(std::size_t number) {
    for (std::vector<std::uint64_t>& words : levels_) {
      std::uint64_t& word = words[number / 64];
      word &= ~(std::uint64_t(1) << number % 64);
      if (word != 0) return;
      number /= 64;
    }
  }

  static constexpr std::size_t none = std::size_t(-1);

  /// The smallest number that is not below `from`, or none.
  std::size_t next(std::size_t from) const {
    for (std::size_t level = 0; level < levels_.size(); ++level) {
      const std::size_t word = from / 64;
      if (word >= levels_[level].size()) return none;
      const std::uint64_t rest = levels_[level][word] >> from % 64;
      if (rest != 0) {
        std::size_t found = from + std::size_t(std::countr_zero(rest));
        for (; level > 0; --level)
          found = 64 * found + std::size_t(std::countr_zero(levels_[level - 1][found]));
        return found;
      }
      from = word + 1;
    }
    return none;
  }

 private:
  std::vector<std::vector<std::uint64_t>> levels_;
};

}  // namespace ragdoll
