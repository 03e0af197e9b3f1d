#include "ragdoll/framework.h"

#include <algorithm>  // sort, adjacent_find, count_if
#include <array>
#include <cmath>    // isfinite
#include <utility>  // move, pair

#include "names.h"          // name_in
#include "ragdoll/error.h"  // Error
#include "stereo.h"         // find_planar_torsions, find_centres

namespace ragdoll {
namespace {

constexpr std::array<std::pair<BarKind, const char*>, bar_kind_count> bar_kinds = {{
    {BarKind::bond, "bond"},
    {BarKind::angle, "angle"},
    {BarKind::planar, "planar"},
    {BarKind::metal, "metal"},
    {BarKind::user, "user"},
}};
constexpr std::array<std::pair<TetherKind, const char*>, tether_kind_count> tether_kinds = {{
    {TetherKind::user, "user"},
    {TetherKind::hydrogen_bond, "hydrogen bond"},
    {TetherKind::salt_bridge, "salt bridge"},
    {TetherKind::hydrophobic, "hydrophobic"},
    {TetherKind::stacking, "stacking"},
    {TetherKind::backbone, "backbone"},
}};
constexpr std::array<std::pair<ContactKind, const char*>, contact_kind_count> contact_kinds = {{
    {ContactKind::user, "user"},
    {ContactKind::hydrogen_bond, "hydrogen bond"},
    {ContactKind::salt_bridge, "salt bridge"},
    {ContactKind::backbone, "backbone"},
    {ContactKind::side_chain, "side chain"},
}};
constexpr std::array<std::pair<VolumeKind, const char*>, volume_kind_count> volume_kinds = {{
    {VolumeKind::chirality, "chirality"},
    {VolumeKind::planarity, "planarity"},
}};

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

void check_held_bonds(const FrameworkParts& parts) {
  for (std::size_t k = 0; k < parts.held_bonds.size(); ++k) {
    const HeldBond& bond = parts.held_bonds[k];
    check_joint(parts, bond.donor, "hydrogen bond", k);
    check_joint(parts, bond.acceptor, "hydrogen bond", k);
    if (bond.hydrogen != -1) check_joint(parts, bond.hydrogen, "hydrogen bond", k);
  }
}

}  // namespace

std::string name_of(BarKind kind) {
  return name_in(bar_kinds, kind);
}

std::string name_of(TetherKind kind) {
  return name_in(tether_kinds, kind);
}

std::string name_of(ContactKind kind) {
  return name_in(contact_kinds, kind);
}

std::string name_of(VolumeKind kind) {
  return name_in(volume_kinds, kind);
}

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
  check_held_bonds(parts_);

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

Framework tightened(const Framework& framework, const Tolerance& tolerance) {
  FrameworkParts parts = framework.parts();
  const double value = tolerance.value();
  // a length whose slack leads to the bound
  for (Tether& tether : parts.tethers)
    tether.length = tolerance.absolute() ? std::max(tether.length - value, tether.length / 2)
                                         : tether.length / (1 + value);
  for (Contact& contact : parts.contacts)
    contact.length =
        tolerance.absolute() ? contact.length + value : contact.length / std::max(1 - value, 0.5);
  return Framework(std::move(parts));
}

}  // namespace ragdoll
