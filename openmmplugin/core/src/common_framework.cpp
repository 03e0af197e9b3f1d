#include "ragdoll/common_framework.h"

#include <algorithm>  // erase_if, max, min
#include <map>
#include <optional>
#include <string>   // to_string
#include <utility>  // move

#include "ragdoll/contact_list.h"  // ContactList
#include "ragdoll/error.h"         // Error

namespace ragdoll {
namespace {

/// Widened bounds leave the second conformation so much room. nm
constexpr double room = 0.002;

/// Pairs of heavy atoms that the second conformation has closer than this share of the contact
/// rule's bound overlap: that is not let in. Hydrogens are placed less well, and always are.
constexpr double least_share = 0.97;

/// Share of their radii that hydrogens keep: side chains have to pass each other, and hydrogens
/// would give way by bending.
constexpr double hydrogen_share = 0.85;

/// No pair is let in closer than this. nm
constexpr double closest = 0.1;

/// dalton; hydrogen and deuterium are lighter
constexpr double heavy = 2.5;

/// Bounds of volumes missed by no more than this share of their scale are widened: a turn of about
/// twenty degrees.
constexpr double volume_margin = 0.35;

class Other {
 public:
  Other(const Framework& framework, std::span<const Vec3> start, std::span<const int> joints,
        std::span<const Vec3> other)
      : start_(start),
        joints_(joints),
        other_(other),
        leader_(nearest_along_bonds(framework, joints)) {}

  bool known(int joint) const {
    const int leader = leader_[std::size_t(joint)];
    return leader >= 0 && joints_[std::size_t(leader)] == joint;
  }

  const Vec3& place(int joint) const { return other_[std::size_t(leader_[std::size_t(joint)])]; }

  /// The distance of a pair, known or guessed; none where nothing tells. nm
  std::optional<double> distance(int p, int q) const {
    const int a = leader_[std::size_t(p)], b = leader_[std::size_t(q)];
    if (a < 0 || b < 0) return std::nullopt;
    const double leaders = (other_[std::size_t(a)] - other_[std::size_t(b)]).norm();
    if (known(p) && known(q)) return leaders;
    return in_start(p, q) + leaders - in_start(joints_[std::size_t(a)], joints_[std::size_t(b)]);
  }

  std::optional<double> volume(const Volume& v) const {
    if (!known(v.a) || !known(v.b) || !known(v.c) || !known(v.d)) return std::nullopt;
    return signed_volume(place(v.a), place(v.b), place(v.c), place(v.d));
  }

 private:
  double in_start(int p, int q) const {
    return (start_[std::size_t(p)] - start_[std::size_t(q)]).norm();
  }

  std::span<const Vec3> start_;
  std::span<const int> joints_;
  std::span<const Vec3> other_;
  std::vector<int> leader_;
};

/// Keeps a bound, widens it, or tells that it has to go.
/// @param missed  by how much; not above 0: not at all
template <class Widen>
bool drop(double missed, double margin, CommonBounds& bounds, Widen widen) {
  if (missed <= 0) {
    ++bounds.kept;
    return false;
  }
  if (missed > margin) {
    ++bounds.dropped;
    return true;
  }
  ++bounds.widened;
  widen();
  return false;
}

/// Pairs that the second conformation has closer than the contact rule allows may be as close.
void let_close_pairs_in(FrameworkParts& parts, std::span<const Vec3> other, const Box* box) {
  ContactRule& rule = parts.contact_rule;
  std::map<std::pair<int, int>, double> lengths;
  for (const ClosePair& pair : rule.close_pairs) lengths[{pair.p, pair.q}] = pair.length;
  const auto is_heavy = [&](int joint) { return parts.masses[std::size_t(joint)] > heavy; };
  ContactList list(rule, 1e-9);
  list.update({other.begin(), other.end()}, box, 0);
  for (const NearPair& pair : list.pairs()) {
    const Vec3 line = other[std::size_t(pair.q)] - other[std::size_t(pair.p)];
    const double distance = (box ? box->minimum_image(line) : line).norm();
    if (distance >= pair.bound || distance < closest) continue;
    if (is_heavy(pair.p) && is_heavy(pair.q) &&
        distance < least_share * rule.rule_bound(pair.p, pair.q))
      continue;
    lengths[{pair.p, pair.q}] = std::max(distance - room, closest);
  }
  rule.close_pairs.clear();
  for (const auto& [pair, length] : lengths)
    rule.close_pairs.push_back({pair.first, pair.second, length});
}

}  // namespace

std::vector<int> nearest_along_bonds(const Framework& framework, std::span<const int> joints) {
  std::vector<int> nearest(std::size_t(framework.joint_count()), -1), queue;
  for (std::size_t k = 0; k < joints.size(); ++k) {
    if (joints[k] < 0 || joints[k] >= framework.joint_count())
      throw Error("joint " + std::to_string(joints[k]) + " of the target is no joint");
    nearest[std::size_t(joints[k])] = int(k);
    queue.push_back(joints[k]);
  }
  for (std::size_t at = 0; at < queue.size(); ++at)
    for (const Graph::Link& link : framework.bond_graph().links(queue[at]))
      if (int& follower = nearest[std::size_t(link.other)]; follower < 0) {
        follower = nearest[std::size_t(queue[at])];
        queue.push_back(link.other);
      }
  return nearest;
}

Framework common_framework(const Framework& framework, std::span<const Vec3> start,
                           std::span<const int> joints, std::span<const Vec3> other, double margin,
                           CommonBounds* bounds, const Box* box) {
  if (int(start.size()) != framework.joint_count())
    throw Error("there are " + std::to_string(start.size()) + " positions for " +
                std::to_string(framework.joint_count()) + " joints");
  if (joints.size() != other.size())
    throw Error("there are " + std::to_string(other.size()) + " places for " +
                std::to_string(joints.size()) + " joints");
  const Other there(framework, start, joints, other);
  CommonBounds counts;
  FrameworkParts parts = framework.parts();
  std::erase_if(parts.tethers, [&](Tether& tether) {
    const double d = there.distance(tether.p, tether.q).value_or(0);
    return drop(d - tether.length, margin, counts, [&] { tether.length = d + room; });
  });
  std::erase_if(parts.contacts, [&](Contact& contact) {
    const double d = there.distance(contact.p, contact.q).value_or(contact.length);
    return drop(contact.length - d, margin, counts,
                [&] { contact.length = std::max(d - room, 0.5 * contact.length); });
  });
  std::erase_if(parts.volumes, [&](Volume& volume) {
    if (volume.kind == VolumeKind::chirality) return false;
    const std::optional<double> v = there.volume(volume);
    if (!v) return false;
    const double missed = std::max(volume.lower - *v, *v - volume.upper) / volume.scale;
    return drop(missed, volume_margin, counts, [&] {
      const double play = 0.02 * volume.scale;
      volume.lower = std::min(volume.lower, *v - play);
      volume.upper = std::max(volume.upper, *v + play);
    });
  });
  for (std::size_t j = 0; j < parts.contact_rule.radii.size(); ++j)
    if (parts.masses[j] <= heavy) parts.contact_rule.radii[j] *= hydrogen_share;
  if (!parts.contact_rule.empty() && int(joints.size()) == framework.joint_count()) {
    std::vector<Vec3> places(start.size());
    for (std::size_t k = 0; k < joints.size(); ++k) places[std::size_t(joints[k])] = other[k];
    let_close_pairs_in(parts, places, box);
  }
  if (bounds) *bounds = counts;
  return Framework(std::move(parts));
}

}  // namespace ragdoll
