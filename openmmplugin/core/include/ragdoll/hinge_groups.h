// Hinge groups: hinges that turn together, and with how many freedoms.

#pragma once
#include <vector>

#include "ragdoll/rigidity.h"  // BodyBarNetwork, Rigidity

namespace ragdoll {

/// Hinges of which none turns alone, such as those of a ring; or one that does.
struct HingeGroup {
  std::vector<int> hinges;  ///< bonds of the network
  int freedom = 0;          ///< independent motions
};

/// Every hinge that turns is in one group. Groups with more freedom, then with more hinges, come
/// first.
std::vector<HingeGroup> hinge_groups(const BodyBarNetwork& network, const Rigidity& rigidity);

}  // namespace ragdoll
