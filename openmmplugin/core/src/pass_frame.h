// Pass frame: positions as the passes work on them, and back. Doubles are what they are; floats are
// taken about a reference point, so that far-away coordinates keep their digits. Private to the
// resolvers.

#pragma once
#include <span>

#include "lane_transfer.h"      // Extent
#include "ragdoll/framework.h"  // Framework
#include "ragdoll/tolerance.h"  // Tolerance
#include "strided_points.h"     // StridedPoints

namespace ragdoll {

template <class T>
class PassFrame;

template <>
class PassFrame<double> {
 public:
  PassFrame(const Framework&, const Tolerance&) {}

  /// @return false if some position is no number
  bool centre(std::span<const Vec3> positions) const;

  void put(const Vec3& position, StridedPoints<double> points, int joint) const {
    points.set(joint, position);
  }
  void take(StridedPoints<double> points, std::span<Vec3> positions) const;
};

template <>
class PassFrame<float> {
 public:
  /// @throw Error if floats cannot hold the tolerance, wherever the joints are
  PassFrame(const Framework& framework, const Tolerance& tolerance);

  /// Puts the reference into the middle of the positions.
  /// @return false if the joints are so far apart, or no numbers, that floats cannot hold the
  ///         tolerance
  bool centre(std::span<const Vec3> positions);
  bool centre(const Extent& extent);

  const Vec3& reference() const { return reference_; }

  /// Whether positions as floats, about the reference, stand for the doubles so closely that a
  /// violation can be told from them.
  bool stands_for_doubles(const Extent& extent) const {
    return extent.lowest.cwiseAbs().cwiseMax(extent.highest.cwiseAbs()).maxCoeff() <= widest_;
  }

  void put(const Vec3& position, StridedPoints<float> points, int joint) const {
    points.set(joint, position - reference_);
  }

  /// Joints that did not move keep the doubles that they had.
  /// @param positions  those that were put; changed in place
  void take(StridedPoints<float> points, std::span<Vec3> positions) const;

 private:
  Eigen::Vector3f single(const Vec3& position) const {
    return (position - reference_).cast<float>();
  }

  double widest_ = 0;  ///< half the extent that floats hold the tolerance over, nm
  Vec3 reference_ = Vec3::Zero();
};

}  // namespace ragdoll
