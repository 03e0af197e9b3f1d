// Lane transfer: conformers' positions into the lanes of an array of floats and back, several lanes
// at a time: one by one, each of their numbers would cost the way to a line of the cache. Private
// to the resolvers.

#pragma once
#include <cstddef>
#include <span>

#include "ragdoll/vec3.h"  // Vec3

namespace ragdoll {

/// What positions span.
struct Extent {
  Vec3 lowest, highest;
  bool finite;  ///< else the others mean nothing
};

/// @param to  the copy (njoint)
Extent copy_and_survey(std::span<const Vec3> positions, Vec3* to);

/// Where a lane comes from.
struct LaneSource {
  const Vec3* positions = nullptr;  ///< (njoint); null: the lane stays as it is
  Vec3 reference = Vec3::Zero();    ///< floats count from here
};

/// @param lanes  (njoint, 3, nlane)
void put_lanes(std::span<const LaneSource> sources, std::size_t joints, float* lanes);

/// @param wanted  not 0: the lane is taken; others may be, too (nlane)
/// @param rows    (nlane, njoint, 3)
void take_lanes(const float* lanes, std::size_t joints, std::span<const float> wanted, float* rows);

/// positions = reference + row. Joints that did not move keep the doubles that they had.
/// @param start  as they were put; maybe the positions themselves
/// @return how many did not move
std::size_t place_row(const float* row, const Vec3& reference, const Vec3* start,
                      std::span<Vec3> positions);

}  // namespace ragdoll
