// ContactTable: a contact rule laid out for looking up many pairs.

#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "ragdoll/contact_rule.h"  // ContactRule

namespace ragdoll {

/// Says what the rule says, which must outlive it, but fast.
class ContactTable {
 public:
  explicit ContactTable(const ContactRule& rule);

  /// The rule's bound or the close pair's, bit for bit; exclusions not considered. p < q, nm
  double bound(int p, int q) const;

  /// p < q
  bool excluded(int p, int q) const;

  /// No bound of a pair is above the sum of its joints' shares, but for rounding; minus infinity
  /// for joints that take no part. nm (njoint)
  std::span<const float> shares() const { return shares_; }

  /// No bound of any pair is above it. nm
  double largest_bound() const { return largest_bound_; }

 private:
  const ContactRule& rule_;
  double allowance_[9] = {};  ///< by the polarities of both ends, nm
  std::vector<float> shares_;
  std::vector<std::uint64_t> nearby_;  ///< bit k of p: p and p + k are excluded (njoint)
  std::vector<std::uint8_t> farther_;  ///< p has exclusions beyond those (njoint)
  std::vector<int> close_begin_;       ///< first close pair of each p (njoint + 1)
  double largest_bound_ = 0;
};

inline bool ContactTable::excluded(int p, int q) const {
  const int apart = q - p;
  if (apart < 64) return (nearby_[std::size_t(p)] >> apart & 1) != 0;
  return farther_[std::size_t(p)] && rule_.excluded(p, q);
}

inline double ContactTable::bound(int p, int q) const {
  const std::size_t i = std::size_t(p), j = std::size_t(q);
  for (int k = close_begin_[i]; k < close_begin_[i + 1]; ++k)
    if (rule_.close_pairs[std::size_t(k)].q == q) return rule_.close_pairs[std::size_t(k)].length;
  if (rule_.radii[i] <= 0 || rule_.radii[j] <= 0) return 0;
  const double bound =
      rule_.scale * (rule_.radii[i] + rule_.radii[j]) -
      allowance_[3 * std::size_t(rule_.polarity[i]) + std::size_t(rule_.polarity[j])];
  return bound < 0 ? 0 : bound;
}

}  // namespace ragdoll
