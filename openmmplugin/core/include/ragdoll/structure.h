// Structure: a bar-and-joint framework with its positions and the names of its joints, as the
// thesis' files hold it; and the forces that act on it.

#pragma once
#include <string>
#include <vector>

#include "ragdoll/framework.h"  // FrameworkParts
#include "ragdoll/vec3.h"       // Vec3

namespace ragdoll {

struct Structure {
  std::vector<std::string> ids;  ///< names of the joints, without spaces (njoint)
  std::vector<Vec3> positions;   ///< in length_unit (njoint)
  FrameworkParts parts;          ///< masses, fixed joints, bars, tethers, contacts
  std::string length_unit = "none";
  std::string class_name = {};  ///< "tree", "1-cycle", ...; empty: not stated
  std::string type = {};        ///< of a 2-cycle: "path", "shared-joint", "theta"; else empty
};

/// One force is one step.
struct Force {
  int joint = 0;
  Vec3 force = Vec3::Zero();
};

struct ForceSet {
  std::vector<Force> forces;
  std::string structure = {};  ///< file that the forces are meant for; empty: any
  long max_iterations = 10000;
  double tolerance = 1e-3;  ///< relative
  double timestep = 1;
};

}  // namespace ragdoll
