#include "ragdoll/framework.h"

#include <algorithm>  // sort, adjacent_find, count_if
#include <cmath>      // isfinite
#include <utility>    // move, pair

#include "ragdoll/error.h"  // Error
#include "stereo.h"         // find_planar_torsions, find_centres

namespace ragdoll {
namespace {

std::string label_of(const FrameworkParts& parts, int joint) {
  if (parts.labels.empty() || parts.labels[std::size_t(joint)].empty())
    return "joint " + std::to_string(joint);
  return parts.labels[std::size_t(joint)];
}

void check_joint(const FrameworkParts& parts, int joint, const char* kind, std::size_t index) {
  if (joint < 0 || joint >= int(parts.masses.size()))
    throw Error(std::string(kind) + " " + std::to_string(index) + " names joint " +
                std::to_string(joint) + ", but there are " + std::to_string(parts.masses.size()));
}

/// Bars, tethers and contacts alike: two different joints and a length.
template <class Pair>
void check_pairs(const FrameworkParts& parts, const std::vector<Pair>& pairs, const char* kind) {
  std::vector<std::pair<int, int>> seen;
  seen.reserve(pairs.size());
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto& pair = pairs[k];
    check_joint(parts, pair.p, kind, k);
    check_joint(parts, pair.q, kind, k);
    if (pair.p == pair.q)
      throw Error(std::string("a ") + kind + " goes from " + label_of(parts, pair.p) +
                  " to itself");
    if (!std::isfinite(pair.length) || pair.length <= 0)
      throw Error(std::string("the ") + kind + " " + label_of(parts, pair.p) + " - " +
                  label_of(parts, pair.q) + " has a length that is not a positive number");
    seen.emplace_back(std::min(pair.p, pair.q), std::max(pair.p, pair.q));
  }
  std::sort(seen.begin(), seen.end());
  const auto twice = std::adjacent_find(seen.begin(), seen.end());
  if (twice != seen.end())
    throw Error(std::string("two ") + kind + "s join " + label_of(parts, twice->first) + " and " +
                label_of(parts, twice->second));
}

void check_volumes(const FrameworkParts& parts) {
  for (std::size_t k = 0; k < parts.volumes.size(); ++k) {
    const Volume& v = parts.volumes[k];
    for (const int joint : {v.a, v.b, v.c, v.d}) check_joint(parts, joint, "volume", k);
    if (!(v.lower <= v.upper) || !(v.scale > 0) || !std::isfinite(v.scale))
      throw Error("volume " + std::to_string(k) + " at " + label_of(parts, v.a) +
                  " has bounds or a scale that make no sense");
  }
}

void check_contact_rule(const FrameworkParts& parts) {
  const ContactRule& rule = parts.contact_rule;
  if (rule.empty()) return;
  const std::size_t n = parts.masses.size();
  if (rule.radii.size() != n || rule.polarity.size() != n || rule.exclusion_begin.size() != n + 1 ||
      rule.exclusion_begin.front() != 0 ||
      rule.exclusion_begin.back() != int(rule.exclusions.size()) ||
      !std::is_sorted(rule.exclusion_begin.begin(), rule.exclusion_begin.end()))
    throw Error("the arrays of the contact rule do not have one entry for each of the " +
                std::to_string(n) + " joints");
  // searching walks these lists side by side
  for (std::size_t p = 0; p < n; ++p) {
    const auto begin = rule.exclusions.begin() + rule.exclusion_begin[p];
    const auto end = rule.exclusions.begin() + rule.exclusion_begin[p + 1];
    if (begin != end && (!std::is_sorted(begin, end) || *begin <= int(p) || *(end - 1) >= int(n)))
      throw Error("the exclusions of " + label_of(parts, int(p)) +
                  " are not later joints in ascending order");
  }
  for (std::size_t k = 0; k < rule.close_pairs.size(); ++k) {
    const ClosePair& pair = rule.close_pairs[k];
    const ClosePair* before = k > 0 ? &rule.close_pairs[k - 1] : nullptr;
    const bool ascending =
        !before || before->p < pair.p || (before->p == pair.p && before->q < pair.q);
    if (!ascending || pair.p < 0 || pair.q <= pair.p || pair.q >= int(n) || !(pair.length >= 0) ||
        !std::isfinite(pair.length))
      throw Error("close pair " + std::to_string(k) +
                  " of the contact rule is out of order, or names no pair of joints with a length");
  }
}

}  // namespace

Framework::Framework(FrameworkParts parts) : parts_(std::move(parts)) {
  const std::size_t n = parts_.masses.size();
  if (n == 0) throw Error("the framework has no joints");
  if (parts_.fixed.empty()) parts_.fixed.assign(n, 0);
  if (parts_.fixed.size() != n || (!parts_.labels.empty() && parts_.labels.size() != n))
    throw Error("the framework's arrays do not have one entry for each of its " +
                std::to_string(n) + " joints");
  for (std::size_t j = 0; j < n; ++j)
    if (!std::isfinite(parts_.masses[j]) || parts_.masses[j] < 0)
      throw Error("the mass of " + name(int(j)) + " is not a number from 0 up");
  check_pairs(parts_, parts_.bars, "bar");
  check_pairs(parts_, parts_.tethers, "tether");
  check_pairs(parts_, parts_.contacts, "contact");
  check_volumes(parts_);
  check_contact_rule(parts_);

  std::vector<std::pair<int, int>> all, bonds;
  all.reserve(parts_.bars.size());
  for (const Bar& bar : parts_.bars) {
    all.emplace_back(bar.p, bar.q);
    if (bar.kind == BarKind::bond) bonds.emplace_back(bar.p, bar.q);
  }
  graph_ = Graph(int(n), all);
  components_ = components_of(graph_);
  bond_graph_ = Graph(int(n), bonds);
  bond_components_ = components_of(bond_graph_);
  planar_torsions_ = find_planar_torsions(parts_, graph_);
  centres_ = find_centres(parts_, graph_);
}

int Framework::chirality_count() const {
  return int(std::count_if(parts_.volumes.begin(), parts_.volumes.end(),
                           [](const Volume& v) { return v.kind == VolumeKind::chirality; }));
}

std::string Framework::name(int joint) const {
  return label_of(parts_, joint);
}

}  // namespace ragdoll
