// Symmetry: copies of one unit that move alike.

#pragma once
#include <span>
#include <vector>

#include "ragdoll/superposition.h"  // RigidMove
#include "ragdoll/vec3.h"           // Vec3

namespace ragdoll {

/// Copies are related by the moves that superpose the first one on each at the start. All copies
/// follow from the first one, so that what is left to move is one copy and what belongs to none.
class Symmetry {
 public:
  /// @param copies  the joints of each copy, those that correspond at one place (ncopy, n)
  /// @throw Error   fewer than two copies, copies of different sizes or of fewer than three joints,
  ///                a joint in two copies, joints that are unknown
  Symmetry(std::vector<std::vector<int>> copies, std::span<const Vec3> start);

  /// Copies 2, 3, ... are placed as the first one says.
  void carry(std::span<Vec3> positions) const;

  /// All copies are replaced by their mean, carried to each.
  void average(std::span<Vec3> positions) const;

  /// How far any joint is from where its copy of the first one would be. nm
  double deviation(std::span<const Vec3> positions) const;

 private:
  std::vector<std::vector<int>> copies_;
  std::vector<RigidMove> moves_;  ///< from the first copy to each (ncopy)
};

}  // namespace ragdoll
