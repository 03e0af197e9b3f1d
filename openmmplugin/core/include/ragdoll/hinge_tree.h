// HingeTree: rigid units and the rotatable bonds between them, and what turns about each.

#pragma once
#include <span>
#include <vector>

#include "ragdoll/framework.h"  // Framework
#include "ragdoll/vec3.h"       // Vec3

namespace ragdoll {

/// A rotatable bond from the root's side to the outer one.
struct Hinge {
  int inner = 0, outer = 0;  ///< joints of the bond
  int first = 0, last = 0;   ///< [first, last) of HingeTree::joints() lies beyond it
  int parent = -1;           ///< the next hinge towards the root; -1: none
  int component = 0;         ///< of the bond graph

  int size() const { return last - first; }
};

/// Bonds that are neither part of a ring of eight or fewer, nor held by planar bars, nor lead to
/// one joint alone, turn; what they join is a unit. A bond that closes a larger ring of units, such
/// as a disulphide bridge, is no hinge.
class HingeTree {
 public:
  explicit HingeTree(const Framework& framework);

  const std::vector<Hinge>& hinges() const { return hinges_; }

  /// All joints, those beyond a hinge side by side. (njoint)
  const std::vector<int>& joints() const { return joints_; }

  /// The joints of the hinge's component: [first, last) of joints().
  std::pair<int, int> component(const Hinge& hinge) const {
    return components_[std::size_t(hinge.component)];
  }

 private:
  std::vector<Hinge> hinges_;
  std::vector<int> joints_;
  std::vector<std::pair<int, int>> components_;
};

}  // namespace ragdoll
