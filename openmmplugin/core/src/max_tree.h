// Max tree: the violations of many bars, and the largest of them. Changing some costs what these
// are, and the log of how many there are in all. Private to the resolvers.

#pragma once
#include <algorithm>  // min, max
#include <cstddef>
#include <utility>  // swap
#include <vector>

namespace ragdoll {

/// How far one bar is violated.
struct BarViolation {
  double relative = 0, nanometers = 0;
};

class MaxTree {
 public:
  explicit MaxTree(std::size_t count) {
    // leaves first, then the largest of each eight, and so on to the root
    std::size_t total = 0;
    for (std::size_t size = groups(count) * arity;; size = groups(size / arity) * arity) {
      level_begin_.push_back(total);
      total += size;
      if (size == arity) break;
    }
    level_begin_.push_back(total);
    value_.resize(total + 1);
    small_ = level_begin_[1] <= 64;
    changed_.reserve(256);
    above_.reserve(256);
  }

  /// Counts from the next settle() on.
  void set(std::size_t index, const BarViolation& now) {
    value_[index] = now;
    if (small_) return;
    // neighbours are most often set one after the other
    if (changed_.empty() || changed_.back() != index / arity) changed_.push_back(index / arity);
  }

  const BarViolation& at(std::size_t index) const { return value_[index]; }

  void settle() {
    if (small_) {
      // four at a time: one does not wait for the other
      BarViolation most[4] = {};
      for (std::size_t k = 0; k < level_begin_[1]; k += 4)
        for (std::size_t i = 0; i < 4; ++i) most[i] = larger(most[i], value_[k + i]);
      value_.back() = larger(larger(most[0], most[1]), larger(most[2], most[3]));
      return;
    }
    for (std::size_t level = 0; level + 1 < level_begin_.size() && !changed_.empty(); ++level) {
      above_.clear();
      for (const std::size_t group : changed_) {
        const BarViolation most = largest_of(&value_[level_begin_[level] + group * arity]);
        BarViolation& parent = value_[level_begin_[level + 1] + group];
        if (most.relative == parent.relative && most.nanometers == parent.nanometers) continue;
        parent = most;
        if (above_.empty() || above_.back() != group / arity) above_.push_back(group / arity);
      }
      std::swap(changed_, above_);
    }
    changed_.clear();
  }

  /// Asks the memory for some that are to be set.
  void fetch(std::size_t first, std::size_t count) const {
    const std::size_t end = std::min(first + count, level_begin_[1]);
    for (std::size_t k = first; k < end; k += arity / 2) __builtin_prefetch(&value_[k]);
  }

  BarViolation largest() const { return value_.back(); }

 private:
  static constexpr std::size_t arity = 8;

  static std::size_t groups(std::size_t count) {
    return std::max<std::size_t>((count + arity - 1) / arity, 1);
  }

  static BarViolation larger(const BarViolation& a, const BarViolation& b) {
    return {std::max(a.relative, b.relative), std::max(a.nanometers, b.nanometers)};
  }

  static BarViolation largest_of(const BarViolation* group) {
    BarViolation most = group[0];
    for (std::size_t k = 1; k < arity; ++k) most = larger(most, group[k]);
    return most;
  }

  std::vector<std::size_t> level_begin_;
  bool small_ = false;                        ///< looking at all is quicker than at what changed
  std::vector<BarViolation> value_;           ///< the root last
  std::vector<std::size_t> changed_, above_;  ///< groups
};

}  // namespace ragdoll
