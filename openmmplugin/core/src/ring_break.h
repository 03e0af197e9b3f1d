// Ring break: what takes the atoms of a ring system out of the shape they are in, before the
// constraints are resolved. Private to core.

#pragma once
#include <array>
#include <span>
#include <vector>

#include "ragdoll/random.h"  // Random
#include "ragdoll/vec3.h"    // Vec3

namespace ragdoll {

/// Of atoms numbered from 0.
class RingBreak {
 public:
  struct Link {
    int a = 0, b = 0;
    bool turns = false;  ///< a bond that may turn
    bool opens = false;  ///< may be opened, so that the others of its ring turn: of a large ring
    /// Where it turns: about a reference torsion abcd, how often each of `bins` angles is drawn,
    /// summed up from the first to 1.
    std::array<int, 4> torsion{};
    std::vector<float> share;
  };
  static constexpr int bins = 36;

  RingBreak(int atoms, std::vector<Link> links);

  /// Another shape from one, unresolved. Small rings are flattened or turned over and shaken; large
  /// ones are opened at a bond, the others turn as their torsions like, and resolving closes the
  /// ring again.
  void apply(std::span<Vec3> positions, Random& random) const;

 private:
  void shake(std::span<Vec3> positions, Random& random) const;
  void turn(std::span<Vec3> positions, Random& random) const;

  int atoms_;
  std::vector<Link> links_;
  std::vector<int> open_;  ///< links that may be opened
  struct Step {
    int other, link;
  };
  std::vector<std::vector<Step>> around_;
};

}  // namespace ragdoll
