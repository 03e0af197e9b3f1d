// Joint places: joints numbered in the order in which a sweep first meets them, so that it finds
// positions next to each other whatever numbers the joints came with. Private to the resolvers.

#pragma once
#include <cstddef>
#include <vector>

#include "ragdoll/order.h"  // Order

namespace ragdoll {

class JointPlaces {
 public:
  JointPlaces(const Order& order, std::size_t joint_count);

  /// Whether a sweep is slowed down by the joints' own numbers: positions are more than the caches
  /// next to the core hold, and lines of them are fetched much more often than once.
  /// @param joint_bytes  of a position
  static bool pay(const Order& order, std::size_t joint_count, std::size_t joint_bytes);

  int of(int joint) const { return of_[std::size_t(joint)]; }

  /// Three numbers for each joint, from its own number to its place, ...
  template <class T>
  void gather(const T* x, std::vector<T>& placed) const {
    placed.resize(3 * joint_at_.size());
    T* to = placed.data();
    for (const int joint : joint_at_) {
      const T* const from = x + 3 * std::ptrdiff_t(joint);
      to[0] = from[0], to[1] = from[1], to[2] = from[2];
      to += 3;
    }
  }

  /// ... and back.
  template <class T>
  void scatter(const std::vector<T>& placed, T* x) const {
    const T* from = placed.data();
    for (const int joint : joint_at_) {
      T* const to = x + 3 * std::ptrdiff_t(joint);
      to[0] = from[0], to[1] = from[1], to[2] = from[2];
      from += 3;
    }
  }

 private:
  std::vector<int> of_;        ///< place of each joint (njoint)
  std::vector<int> joint_at_;  ///< joint at each place (njoint)
};

}  // namespace ragdoll
