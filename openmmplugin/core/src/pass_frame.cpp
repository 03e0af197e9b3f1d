#include "pass_frame.h"

#include <algorithm>  // min, max
#include <cstdio>     // snprintf
#include <limits>     // infinity
#include <string>

#include "ragdoll/error.h"  // Error

namespace ragdoll {
namespace {

/// Of a length: what its tolerance has to be at least. Floats round at 6e-8, a few times over.
constexpr double smallest_relative = 1e-5;

/// Of the distance from the reference: what the tolerance has to be at least, a few roundings.
constexpr double share_of_extent = 1e-6;

}  // namespace

PassFrame<float>::PassFrame(const Framework& framework, const Tolerance& tolerance) {
  double shortest = std::numeric_limits<double>::infinity(), longest = 0;
  const auto consider = [&](double length) {
    shortest = std::min(shortest, length);
    longest = std::max(longest, length);
  };
  for (const Bar& bar : framework.bars()) consider(bar.length);
  for (const Tether& tether : framework.tethers()) consider(tether.length);
  for (const Contact& contact : framework.contacts()) consider(contact.length);
  const double smallest = tolerance.absolute() ? smallest_relative * longest : smallest_relative;
  if (tolerance.value() < smallest) {
    char sentence[160];
    std::snprintf(sentence, sizeof sentence,
                  "precision single holds tolerances of %.2g%s or more here; choose one, or "
                  "precision double",
                  smallest, tolerance.absolute() ? " nm" : "");
    throw Error(sentence);
  }
  widest_ = tolerance.slack(shortest) / share_of_extent;
}

bool PassFrame<double>::centre(std::span<const Vec3> positions) const {
  double sum = 0;
  for (const Vec3& position : positions) sum += position.sum() * 0;
  return sum == 0;
}

void PassFrame<double>::take(StridedPoints<double> points, std::span<Vec3> positions) const {
  for (std::size_t j = 0; j < positions.size(); ++j) positions[j] = points.at(int(j));
}

bool PassFrame<float>::centre(std::span<const Vec3> positions) {
  Vec3 lowest = positions.front(), highest = lowest;
  double sum = 0;
  for (const Vec3& position : positions) {
    lowest = lowest.cwiseMin(position);
    highest = highest.cwiseMax(position);
    sum += position.sum() * 0;
  }
  // as positions that are no numbers do not
  return centre(Extent{lowest, highest, sum == 0});
}

bool PassFrame<float>::centre(const Extent& extent) {
  reference_ = extent.lowest / 2 + extent.highest / 2;
  return extent.finite && (extent.highest - extent.lowest).maxCoeff() <= 2 * widest_;
}

void PassFrame<float>::take(StridedPoints<float> points, std::span<Vec3> positions) const {
  for (std::size_t j = 0; j < positions.size(); ++j) {
    const Vec3 point = points.at(int(j));
    if (single(positions[j]) != point.cast<float>()) positions[j] = reference_ + point;
  }
}

}  // namespace ragdoll
