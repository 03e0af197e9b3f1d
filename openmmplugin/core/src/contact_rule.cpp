#include "ragdoll/contact_rule.h"

#include <algorithm>  // binary_search, lower_bound, max_element
#include <tuple>      // tie
#include <utility>    // swap

namespace ragdoll {

double ContactRule::rule_bound(int p, int q) const {
  const std::size_t i = std::size_t(p), j = std::size_t(q);
  // a joint without a radius takes no part
  if (radii[i] <= 0 || radii[j] <= 0) return 0;
  double bound = scale * (radii[i] + radii[j]);
  const Polarity a = polarity[i], b = polarity[j];
  if (a == Polarity::heavy && b == Polarity::heavy)
    bound -= heavy_allowance;
  else if ((a == Polarity::heavy && b == Polarity::hydrogen) ||
           (a == Polarity::hydrogen && b == Polarity::heavy))
    bound -= hydrogen_allowance;
  return std::max(bound, 0.0);
}

double ContactRule::bound(int p, int q) const {
  if (p > q) std::swap(p, q);
  const auto close = std::lower_bound(close_pairs.begin(), close_pairs.end(), ClosePair{p, q, 0},
                                      [](const ClosePair& a, const ClosePair& b) {
                                        return std::tie(a.p, a.q) < std::tie(b.p, b.q);
                                      });
  if (close != close_pairs.end() && close->p == p && close->q == q) return close->length;
  return rule_bound(p, q);
}

bool ContactRule::excluded(int p, int q) const {
  const auto begin = exclusions.begin() + exclusion_begin[std::size_t(p)];
  const auto end = exclusions.begin() + exclusion_begin[std::size_t(p) + 1];
  return std::binary_search(begin, end, q);
}

double ContactRule::largest_bound() const {
  if (empty()) return 0;
  return 2 * scale * *std::max_element(radii.begin(), radii.end());
}

}  // namespace ragdoll
