#include "ragdoll/common_framework.h"

#include <algorithm>  // erase_if, max, min
#include <cmath>      // isfinite
#include <optional>
#include <string>   // to_string
#include <utility>  // move

#include "ragdoll/error.h"  // Error

namespace ragdoll {
namespace {

/// Widened bounds leave the second conformation so much room. nm
constexpr double room = 0.002;

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
                           CommonBounds* bounds) {
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
  if (bounds) *bounds = counts;
  return Framework(std::move(parts));
}

}  // namespace ragdoll
