// Tests for core/src/lane_transfer.cpp: positions go into lanes and out of them.

#include "lane_transfer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "ragdoll/random.h"
#include "vector_targets.h"

namespace ragdoll {
namespace {

using examples::for_each_vector_target;
using Positions = std::vector<Vec3>;

Positions anywhere(std::size_t joints, std::uint64_t seed) {
  Random random(seed, RandomStream::generate, 0);
  Positions x(joints);
  for (Vec3& point : x) point = Vec3(random.gaussian(), random.gaussian(), random.gaussian());
  return x;
}

TEST(LaneTransfer, ExtentIsThatOfThePositionsAndTellsWhatIsNoNumber) {
  for_each_vector_target([&] {
    for (const std::size_t joints : {1u, 7u, 8u, 50u}) {
      const Positions x = anywhere(joints, joints);
      Positions copy(joints);
      const Extent extent = copy_and_survey(x, copy.data());
      EXPECT_EQ(copy, x);
      EXPECT_TRUE(extent.finite);
      for (int axis = 0; axis < 3; ++axis) {
        const auto less = [axis](const Vec3& a, const Vec3& b) { return a[axis] < b[axis]; };
        EXPECT_EQ(extent.lowest[axis], (*std::min_element(x.begin(), x.end(), less))[axis]);
        EXPECT_EQ(extent.highest[axis], (*std::max_element(x.begin(), x.end(), less))[axis]);
      }
      for (const double no_number : {std::nan(""), std::numeric_limits<double>::infinity()})
        for (std::size_t j = 0; j < joints; ++j) {
          Positions wrong = x;
          wrong[j][1] = no_number;
          EXPECT_FALSE(copy_and_survey(wrong, copy.data()).finite) << j;
        }
    }
  });
}

TEST(LaneTransfer, LanesThatAreNotLoadedStay) {
  for_each_vector_target([&] {
    for (const std::size_t width : {1u, 2u, 4u})
      for (const std::size_t joints : {1u, 5u, 37u}) {
        const Vec3 reference(0.5, -2, 7);
        std::vector<float> lanes(3 * joints * width, 3.0f);
        std::vector<Positions> starts;
        for (std::size_t l = 0; l < width; ++l) starts.push_back(anywhere(joints, l));
        std::vector<LaneSource> sources(width);
        for (std::size_t l = 0; l < width; l += 2) sources[l] = {starts[l].data(), reference};
        put_lanes(sources, joints, lanes.data());
        std::vector<float> rows(lanes.size());
        take_lanes(lanes.data(), joints, std::vector<float>(width, 1.0f), rows.data());
        for (std::size_t l = 0; l < width; ++l)
          for (std::size_t e = 0; e < 3 * joints; ++e) {
            const auto axis = Eigen::Index(e % 3);
            const float expected =
                l % 2 == 0 ? float(starts[l][e / 3][axis] - reference[axis]) : 3.0f;
            EXPECT_EQ(rows[l * 3 * joints + e], expected);
          }
      }
  });
}

TEST(LaneTransfer, JointsThatDidNotMoveKeepTheirDoubles) {
  for_each_vector_target([&] {
    const Positions start = anywhere(21, 3);
    const Vec3 reference(1, 2, 3);
    std::vector<float> row;
    for (const Vec3& point : start)
      for (int axis = 0; axis < 3; ++axis) row.push_back(float(point[axis] - reference[axis]));
    Positions x(start.size());
    EXPECT_EQ(place_row(row.data(), reference, start.data(), x), start.size());
    EXPECT_EQ(x, start);
    row[3 * 4 + 1] += 1;
    EXPECT_EQ(place_row(row.data(), reference, start.data(), x), start.size() - 1);
    EXPECT_EQ(x[3], start[3]);
    EXPECT_EQ(x[4], reference + Vec3(row[12], row[13], row[14]));
  });
}

}  // namespace
}  // namespace ragdoll
