// Points and vectors, and the small geometry that several stages share.

#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>  // cross

namespace ragdoll {

using Vec3 = Eigen::Vector3d;  ///< nm; three doubles without padding

/// Six times the signed volume of the tetrahedron abcd: (b-a) . ((c-a) x (d-a)).
inline double signed_volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return (b - a).dot((c - a).cross(d - a));
}

}  // namespace ragdoll
