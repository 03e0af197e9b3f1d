// Box: periodic box vectors in OpenMM's reduced form, and the minimum image in them.

#pragma once
#include <cmath>

#include "ragdoll/vec3.h"  // Vec3

namespace ragdoll {

struct Box {
  Vec3 a, b, c;  ///< nm; a along x, b in the xy plane, reduced

  /// The shortest periodic image of a difference vector.
  Vec3 minimum_image(Vec3 d) const {
    d -= c * std::round(d[2] / c[2]);
    d -= b * std::round(d[1] / b[1]);
    d -= a * std::round(d[0] / a[0]);
    return d;
  }
};

}  // namespace ragdoll
