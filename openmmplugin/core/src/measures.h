// Angles and torsions between points.

#pragma once
#include <array>
#include <cmath>  // atan2
#include <numbers>
#include <span>

#include "ragdoll/vec3.h"  // Vec3

namespace ragdoll {

constexpr double degrees_per_radian = 180 / std::numbers::pi;

/// At b between a and c, rad, 0 to pi.
inline double angle(std::span<const Vec3> x, const std::array<int, 3>& abc) {
  const Vec3 u = x[std::size_t(abc[0])] - x[std::size_t(abc[1])];
  const Vec3 v = x[std::size_t(abc[2])] - x[std::size_t(abc[1])];
  return std::atan2(u.cross(v).norm(), u.dot(v));
}

/// About bc, rad, -pi to pi; 0 where a and d are cis.
inline double torsion(std::span<const Vec3> x, const std::array<int, 4>& abcd) {
  const Vec3 ab = x[std::size_t(abcd[1])] - x[std::size_t(abcd[0])];
  const Vec3 bc = x[std::size_t(abcd[2])] - x[std::size_t(abcd[1])];
  const Vec3 cd = x[std::size_t(abcd[3])] - x[std::size_t(abcd[2])];
  const Vec3 n = bc.cross(cd);
  return std::atan2(bc.norm() * ab.dot(n), ab.cross(bc).dot(n));
}

}  // namespace ragdoll
