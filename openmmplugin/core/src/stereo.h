// Stereo: what of a framework has a side or a hand, found from its bars, and whether positions keep
// it. Private to core.

#pragma once
#include <span>
#include <vector>

#include "ragdoll/framework.h"  // FrameworkParts, PlanarTorsion, Volume
#include "ragdoll/vec3.h"       // Vec3

namespace ragdoll {

/// One for each bond that planar bars go across. @param graph  of all bars
std::vector<PlanarTorsion> find_planar_torsions(const FrameworkParts& parts, const Graph& graph);

/// For each volume the joint that is bonded to its four and lies within them; -1 where none does.
std::vector<int> find_centres(const FrameworkParts& parts, const Graph& graph);

/// Whether a and d are on the same side of the bond bc.
inline bool is_cis(std::span<const Vec3> positions, const PlanarTorsion& t) {
  const auto x = [&](int joint) -> const Vec3& { return positions[std::size_t(joint)]; };
  const Vec3 bc = x(t.c) - x(t.b);
  return (x(t.b) - x(t.a)).cross(bc).dot(bc.cross(x(t.d) - x(t.c))) > 0;
}

/// Whether a point lies within the four joints of a volume, whose sign is given: it sees each three
/// of them turn as they do from within.
inline bool is_within(std::span<const Vec3> positions, const Volume& v, const Vec3& point,
                      bool right_handed) {
  const auto from_point = [&](int joint) { return Vec3(positions[std::size_t(joint)] - point); };
  const Vec3 a = from_point(v.a), b = from_point(v.b), c = from_point(v.c), d = from_point(v.d);
  const Vec3 ab = a.cross(b), cd = c.cross(d);
  const double sign = right_handed ? 1 : -1;
  return sign * ab.dot(c) < 0 && sign * ab.dot(d) > 0 && sign * cd.dot(a) < 0 &&
         sign * cd.dot(b) > 0;
}

/// Chirality volumes of the wrong sign, or whose centre has left them through a face; the bound
/// that is finite tells the sign.
bool is_inverted(const Framework& framework, std::size_t volume, std::span<const Vec3> positions);

}  // namespace ragdoll
