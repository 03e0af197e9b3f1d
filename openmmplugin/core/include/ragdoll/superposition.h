// Superposition: root mean square deviation after the best rotation and translation.

#pragma once
#include <span>
#include <vector>

#include "ragdoll/vec3.h"  // Vec3

namespace ragdoll {

/// Least RMSD of two sets of points over all rotations and translations (Horn, J. Opt. Soc.
/// Am. A 4, 629, 1987). nm
/// @throw Error if the sets are empty or differ in size
double superposed_rmsd(std::span<const Vec3> a, std::span<const Vec3> b);

/// A rotation and a translation.
struct RigidMove {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Vec3 translation = Vec3::Zero();  ///< nm, after the rotation

  Vec3 operator()(const Vec3& point) const { return rotation * point + translation; }
  RigidMove inverse() const {
    return {rotation.transpose(), -(rotation.transpose() * translation)};
  }
};

/// The move that brings the points of `a` closest to those of `b`, by weighted least squares.
/// @param weights  of the points, not negative (npoint), or empty: all alike
/// @throw Error if the sets are empty or differ in size, or no point has weight
RigidMove superposition(std::span<const Vec3> a, std::span<const Vec3> b,
                        std::span<const double> weights = {});

/// The points at these indices.
std::vector<Vec3> chosen(std::span<const Vec3> points, std::span<const int> indices);

}  // namespace ragdoll
