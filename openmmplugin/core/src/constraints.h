// Constraints: how far one of them is violated, and how it is corrected. Private to the resolvers.

#pragma once
#include <cmath>  // sqrt, isfinite
#include <span>
#include <string>

#include "ragdoll/error.h"      // Error
#include "ragdoll/framework.h"  // Volume
#include "ragdoll/vec3.h"       // Vec3

namespace ragdoll {

/// Violation of a volume's bounds, relative to its scale; 0 inside them.
inline double volume_violation(const Volume& v, double volume) {
  if (volume < v.lower) return (v.lower - volume) / v.scale;
  if (volume > v.upper) return (volume - v.upper) / v.scale;
  return 0;
}

/// Whether bars are all that holds the joints.
inline bool has_bars_only(const Framework& framework) {
  return framework.tethers().empty() && framework.contacts().empty() &&
         framework.volumes().empty() && framework.contact_rule().empty();
}

/// @throw Error  on a root that is no joint
inline void check_roots(const Framework& framework, std::span<const int> roots) {
  for (const int root : roots)
    if (root < 0 || root >= framework.joint_count())
      throw Error("root " + std::to_string(root) + " is no joint; there are " +
                  std::to_string(framework.joint_count()));
}

/// Gradients of the signed volume with respect to b, c and d; a's is minus their sum.
struct VolumeGradient {
  Vec3 a, b, c, d;
  VolumeGradient(const Vec3& xa, const Vec3& xb, const Vec3& xc, const Vec3& xd) {
    const Vec3 ab = xb - xa, ac = xc - xa, ad = xd - xa;
    b = ac.cross(ad);
    c = ad.cross(ab);
    d = ab.cross(ac);
    a = -(b + c + d);
  }
};

}  // namespace ragdoll
