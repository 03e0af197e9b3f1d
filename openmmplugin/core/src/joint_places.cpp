#include "joint_places.h"

#include <array>

namespace ragdoll {
namespace {

constexpr std::size_t near_cache = 1 << 20;  ///< bytes of positions that need no help
constexpr std::size_t line = 64;             ///< bytes
constexpr std::size_t lines = 1 << 12;       ///< that are taken to be at hand
/// Times that lines are fetched more often than once, from which on copying positions to their
/// places and back is paid for by the first pass or two.
constexpr double scattered = 2;

}  // namespace

JointPlaces::JointPlaces(const Order& order, std::size_t joint_count) : of_(joint_count, -1) {
  joint_at_.reserve(joint_count);
  const auto meet = [this](int joint) {
    int& place = of_[std::size_t(joint)];
    if (place >= 0) return;
    place = int(joint_at_.size());
    joint_at_.push_back(joint);
  };
  for (const Visit& visit : order) {
    meet(visit.near);
    meet(visit.far);
  }
  // joints without bars
  for (int joint = 0; joint < int(joint_count); ++joint) meet(joint);
}

bool JointPlaces::pay(const Order& order, std::size_t joint_count, std::size_t joint_bytes) {
  if (joint_count * joint_bytes <= near_cache) return false;
  // a cache in which a line has one place
  std::array<std::size_t, lines> held;
  held.fill(std::size_t(-1));
  std::size_t fetched = 0;
  const auto touch = [&](int joint) {
    const std::size_t wanted = std::size_t(joint) * joint_bytes / line;
    std::size_t& at = held[wanted % lines];
    fetched += at != wanted;
    at = wanted;
  };
  for (const Visit& visit : order) {
    touch(visit.near);
    touch(visit.far);
  }
  return double(fetched) > scattered * double(joint_count * joint_bytes) / line;
}

}  // namespace ragdoll
