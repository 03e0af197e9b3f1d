// Clouds, boxes and rules for the tests of contacts.

#pragma once
#include <algorithm>  // max
#include <cmath>      // sqrt
#include <utility>    // move
#include <vector>

#include "examples.h"
#include "ragdoll/contact_list.h"  // NearPair

namespace ragdoll::examples {

inline Random dice(std::uint64_t seed) {
  return Random(seed, RandomStream::generate, 0);
}

inline Box rectangular(double a, double b, double c) {
  return {{a, 0, 0}, {0, b, 0}, {0, 0, c}};
}

/// OpenMM's reduced forms: a rhombic dodecahedron, and one skewed as far as they allow.
inline Box dodecahedron(double edge) {
  return {{edge, 0, 0}, {0, edge, 0}, {edge / 2, edge / 2, edge * std::sqrt(0.5)}};
}
inline Box skewed(double edge) {
  return {{edge, 0, 0}, {-0.5 * edge, 1.1 * edge, 0}, {0.5 * edge, -0.55 * edge, 1.3 * edge}};
}

inline double distance_of(const Positions& x, int p, int q, const Box* box) {
  const Vec3 d = x[std::size_t(q)] - x[std::size_t(p)];
  return (box ? box->minimum_image(d) : d).norm();
}

inline ContactRule rule_of(std::vector<double> radii, std::vector<Polarity> polarity) {
  ContactRule rule;
  rule.exclusion_begin.assign(radii.size() + 1, 0);
  rule.radii = std::move(radii);
  rule.polarity = std::move(polarity);
  rule.scale = 0.5;
  rule.heavy_allowance = 0.01;
  rule.hydrogen_allowance = 0.05;
  return rule;
}

/// Radii, polarities, exclusions and close pairs at random.
inline ContactRule random_rule(int joints, Random& random) {
  ContactRule rule;
  rule.scale = 0.8;
  rule.heavy_allowance = 0.02;
  rule.hydrogen_allowance = 0.06;
  rule.exclusion_begin = {0};
  for (int p = 0; p < joints; ++p) {
    rule.radii.push_back(random.below(10) == 0 ? 0 : 0.1 + 0.1 * random.uniform());
    rule.polarity.push_back(Polarity(random.below(3)));
    for (int q = p + 1; q < joints; ++q) {
      const std::uint64_t kind = random.below(10);
      if (kind == 0) rule.exclusions.push_back(q);
      if (kind == 1) rule.close_pairs.push_back({p, q, 0.05 + 0.1 * random.uniform()});
    }
    rule.exclusion_begin.push_back(int(rule.exclusions.size()));
  }
  return rule;
}

/// Every pair closer than its bound plus `reach`, with its bound, by the rule's own words.
inline std::vector<NearPair> near_pairs(const ContactRule& rule, const Positions& x, double reach,
                                        const Box* box) {
  std::vector<NearPair> pairs;
  for (int p = 0; p < int(x.size()); ++p)
    for (int q = p + 1; q < int(x.size()); ++q) {
      if (rule.excluded(p, q) || rule.radii[std::size_t(p)] == 0) continue;
      if (rule.radii[std::size_t(q)] == 0) continue;
      const double bound = rule.bound(p, q);
      if (bound > 0 && distance_of(x, p, q, box) < bound + reach) pairs.push_back({p, q, bound});
    }
  return pairs;
}

inline bool same(const NearPair& a, const NearPair& b) {
  return a.p == b.p && a.q == b.q && a.bound == b.bound;
}

/// Close pairs of joints without a radius are left out: the rule watches none of theirs.
inline ContactRule random_rule_of_all(int joints, Random& random) {
  ContactRule rule = random_rule(joints, random);
  for (double& radius : rule.radii) radius = std::max(radius, 0.1);
  return rule;
}

}  // namespace ragdoll::examples
