#include "ragdoll/contact_table.h"

#include <algorithm>  // max
#include <limits>     // infinity

namespace ragdoll {

ContactTable::ContactTable(const ContactRule& rule) : rule_(rule) {
  const auto allowance = [this](Polarity p, Polarity q) -> double& {
    return allowance_[3 * std::size_t(p) + std::size_t(q)];
  };
  allowance(Polarity::heavy, Polarity::heavy) = rule.heavy_allowance;
  allowance(Polarity::heavy, Polarity::hydrogen) = rule.hydrogen_allowance;
  allowance(Polarity::hydrogen, Polarity::heavy) = rule.hydrogen_allowance;

  const std::size_t n = rule.radii.size();
  nearby_.assign(n, 0);
  farther_.assign(n, 0);
  for (std::size_t p = 0; p < n; ++p)
    for (int k = rule.exclusion_begin[p]; k < rule.exclusion_begin[p + 1]; ++k) {
      const std::size_t apart = std::size_t(rule.exclusions[std::size_t(k)]) - p;
      if (apart < 64)
        nearby_[p] |= std::uint64_t(1) << apart;
      else
        farther_[p] = 1;
    }

  close_begin_.assign(n + 1, 0);
  // a close pair that is held farther apart than the radii say widens every share
  double excess = 0;
  for (const ClosePair& pair : rule.close_pairs) {
    const std::size_t p = std::size_t(pair.p), q = std::size_t(pair.q);
    ++close_begin_[p + 1];
    if (rule.radii[p] > 0 && rule.radii[q] > 0)
      excess = std::max(excess, pair.length - rule.scale * (rule.radii[p] + rule.radii[q]));
  }
  for (std::size_t p = 0; p < n; ++p) close_begin_[p + 1] += close_begin_[p];
  shares_.reserve(n);
  for (const double radius : rule.radii)
    shares_.push_back(radius > 0 ? float(rule.scale * radius + excess / 2)
                                 : -std::numeric_limits<float>::infinity());
  largest_bound_ = rule.largest_bound() + excess;
}

}  // namespace ragdoll
