// Framework pieces: the parts of a framework that no constraint joins, and frameworks made of some
// of them. Private to the resolvers.

#pragma once
#include <memory>
#include <span>
#include <vector>

#include "ragdoll/framework.h"  // Framework

namespace ragdoll {

/// Joints that bars, tethers, contacts and volumes join, however far around. A contact rule joins
/// all.
struct Piece {
  int components = 0;  ///< of the bars
  int joints = 0, bars = 0, tethers = 0;
  double length = 0;  ///< of the bars, in all
  bool bars_only = true;

  bool is_free() const { return bars == 0 && bars_only; }  ///< one joint that nothing holds
};

struct Pieces {
  std::vector<int> of_joint;  ///< (njoint)
  std::vector<Piece> pieces;  ///< in the order of their lowest joints
};

Pieces pieces_of(const Framework& framework);

/// Some joints of a framework, with all that holds them.
struct SubFramework {
  std::shared_ptr<const Framework> framework;
  std::vector<int> joints;  ///< of the whole framework, ascending
};

/// @param taken  1: the joint's piece is in it (njoint); a contact rule's framework is taken whole
SubFramework sub_framework(const Framework& whole, std::span<const unsigned char> taken);

}  // namespace ragdoll
