// Force run: one structure, one technique, and a set of forces, each of them one step of break and
// resolve.

#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ragdoll/break.h"      // VerletScope
#include "ragdoll/resolver.h"   // ResolverSettings, ResolveReport
#include "ragdoll/structure.h"  // Structure, ForceSet

namespace ragdoll {

/// The structure's framework; its joints are named by their ids.
/// @throw Error as Framework does
std::shared_ptr<const Framework> framework_of(const Structure& structure);

struct ForceRunSettings {
  ResolverSettings resolver = {};  ///< its tolerance and maximum give way to those of the forces
  /// In the place of the forces', which is relative.
  std::optional<Tolerance> tolerance = {};
  VerletScope verlet = VerletScope::affected;
  bool frames = false;  ///< keep the positions after each force
  /// Called after each force with the number of forces done; false: stop there.
  std::function<bool(std::size_t)> progress = {};
};

struct ForceRun {
  std::vector<ResolveReport> reports;     ///< (nforce)
  std::vector<Vec3> positions;            ///< after the last force (njoint)
  std::string solver;                     ///< that worked
  std::vector<std::vector<Vec3>> frames;  ///< after each force (nforce of njoint), if asked for
};

/// x_new = 2 x - x_old + F/m dt^2, then the constraints; x_old is each joint's position before the
/// previous step, and at the start the joints are at rest. `affected` moves the joint that the
/// force acts on, even by a force of zero; `all` moves every joint. Either way the forced joint is
/// the root. A force that is not resolved leaves the joints where the last iteration left them, and
/// the next one starts there. Force k draws its random orders from step k.
/// @throw Error on a force whose joint does not exist or that is not finite, a timestep that is not
///              positive, and as make_resolver does
ForceRun run_forces(const Structure& structure, const ForceSet& forces,
                    const ForceRunSettings& settings = {});

/// The same on a framework that is made already, so that several techniques share it.
ForceRun run_forces(std::shared_ptr<const Framework> framework, const std::vector<Vec3>& positions,
                    const ForceSet& forces, const ForceRunSettings& settings);

}  // namespace ragdoll
