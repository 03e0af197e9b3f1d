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
    changed_.reserve(256);
    above_.reserve(256);
  }

  /// Counts from the next settle() on.
  void set(std::size_t index, const BarViolation& now) {
    value_[index] = now;
    if (small()) return;
    // neighbours are most often set one after the other
    if (changed_.empty() || changed_.back() != index / arity) changed_.push_back(index / arity);
  }

  void settle() {
    if (small()) {
      BarViolation most;
      for (std::size_t k = 0; k < level_begin_[1]; ++k) most = larger(most, value_[k]);
      value_.back() = most;
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

  /// Looking at all is quicker than at what changed.
  bool small() const { return level_begin_[1] <= 64; }

  static BarViolation larger(const BarViolation& a, const BarViolation& b) {
    return {std::max(a.relative, b.relative), std::max(a.nanometers, b.nanometers)};
  }

  static BarViolation largest_of(const BarViolation* group) {
    BarViolation most = group[0];
    for (std::size_t k = 1; k < arity; ++k) most = larger(most, group[k]);
    return most;
  }

  std::vector<std::size_t> level_begin_;
  std::vector<BarViolation> value_;           ///< the root last
  std::vector<std::size_t> changed_, above_;  ///< groups
};

}  // namespace ragdoll
