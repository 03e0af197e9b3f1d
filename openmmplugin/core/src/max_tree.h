// Max tree: the violations of many bars, and the largest of them. Changing one costs no more than
// the log of their count, and most often one or two steps. Private to the resolvers.

#pragma once
#include <algorithm>  // max
#include <cstddef>
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
  }

  BarViolation largest() const { return value_.back(); }

  void set(std::size_t index, BarViolation now) {
    BarViolation before = value_[index];
    value_[index] = now;
    for (std::size_t level = 0; level + 1 < level_begin_.size(); ++level) {
      const BarViolation* const group = &value_[level_begin_[level] + index / arity * arity];
      index /= arity;
      BarViolation& parent = value_[level_begin_[level + 1] + index];
      const BarViolation above = {larger<&BarViolation::relative>(group, parent, before, now),
                                  larger<&BarViolation::nanometers>(group, parent, before, now)};
      if (above.relative == parent.relative && above.nanometers == parent.nanometers) return;
      before = parent;
      parent = now = above;
    }
  }

 private:
  static constexpr std::size_t arity = 8;

  static std::size_t groups(std::size_t count) {
    return std::max<std::size_t>((count + arity - 1) / arity, 1);
  }

  /// The group is looked through only where its largest became smaller.
  template <double BarViolation::*Part>
  static double larger(const BarViolation* group, const BarViolation& parent,
                       const BarViolation& before, const BarViolation& now) {
    if (now.*Part >= parent.*Part) return now.*Part;
    if (before.*Part < parent.*Part) return parent.*Part;
    double most = group[0].*Part;
    for (std::size_t k = 1; k < arity; ++k) most = std::max(most, group[k].*Part);
    return most;
  }

  std::vector<std::size_t> level_begin_;
  std::vector<BarViolation> value_;  ///< the root last
};

}  // namespace ragdoll
