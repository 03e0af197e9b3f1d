// Strided points: joints' positions somewhere in memory, in floats or doubles: an array of points,
// or one lane of an array that holds the lanes side by side. Private to the resolvers.

#pragma once
#include <cstddef>
#include <vector>

#include "ragdoll/vec3.h"  // Vec3

namespace ragdoll {

template <class T>
struct StridedPoints {
  T* data = nullptr;
  std::size_t count = 0;
  std::size_t joint_stride = 3, axis_stride = 1;

  Vec3 at(int joint) const {
    const T* const point = data + std::size_t(joint) * joint_stride;
    return {double(point[0]), double(point[axis_stride]), double(point[2 * axis_stride])};
  }

  /// Rounds to T.
  void set(int joint, const Vec3& position) const {
    T* const point = data + std::size_t(joint) * joint_stride;
    for (std::size_t i = 0; i < 3; ++i) point[i * axis_stride] = T(position[Eigen::Index(i)]);
  }

  void copy_to(std::vector<Vec3>& positions) const {
    positions.resize(count);
    for (std::size_t j = 0; j < count; ++j) positions[j] = at(int(j));
  }
};

}  // namespace ragdoll
