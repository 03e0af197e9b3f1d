// Motion: what moves a walker's joints before the constraints are resolved. A motion belongs to one
// walker and may remember where that walker went.

#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "ragdoll/break.h"      // PerturbationKind
#include "ragdoll/framework.h"  // Framework
#include "ragdoll/random.h"     // Random
#include "ragdoll/vec3.h"       // Vec3

namespace ragdoll {

enum class MotionKind {
  gaussian,  ///< each coordinate normal
  ball,      ///< FRODA's: each joint uniform in a ball
  momentum,  ///< the last step again, times a factor, and a random part
  hinge,     ///< parts turn about rotatable bonds
  modes,     ///< out and back along given directions, both ways
  steer,     ///< pulled by the user
  away,      ///< away from where the walker was
  thermal,   ///< given modes swing, all at once
};

/// "gaussian", "ball", "momentum", ... @throw Error
MotionKind motion_kind(const std::string& name);
std::string name_of(MotionKind kind);
std::vector<std::string> motion_names();

/// Joints that are pulled: all by one vector, or their centroid towards a point.
struct Pull {
  std::vector<int> joints;
  Vec3 vector = Vec3::Zero();  ///< nm in each step; towards a point: its length alone counts
  bool towards_point = false;
  Vec3 point = Vec3::Zero();  ///< nm
};

/// From what a walker is pushed away.
enum class AwayFrom {
  nearest,   ///< the conformer it visited that is the nearest by RMSD
  centroid,  ///< the mean of those
  density,   ///< all of them, the nearer the more: down the density of a Gaussian around each
};

/// "nearest", "centroid" or "density". @throw Error
AwayFrom away_from(const std::string& name);
std::string name_of(AwayFrom from);

struct MotionSettings {
  MotionKind kind = MotionKind::gaussian;
  double size = 0.01;  ///< of the random part of each motion, nm

  double persistence = 0.95;  ///< momentum: the share of the last step that is made again

  double hinge_angle = 0.17;  ///< hinge: deviation of the turns, rad
  double hinge_share = 0.05;  ///< hinge: of the hinges that turn in one step
  double hinge_reach = 0.1;   ///< hinge: the most that a turn moves its joints by, RMS, nm

  /// modes: directions, of any length; thermal: displacements of one deviation, nm (nmode, njoint)
  std::vector<std::vector<Vec3>> modes = {};
  double mode_amplitude = 0.2;  ///< modes: RMSD from the start at which a mode turns back, nm
  double mode_step = 0.01;      ///< modes: RMSD of one step along the mode, nm

  double thermal_step = 0.05;  ///< thermal: RMSD of a step, nm
  double memory = 0.9;         ///< thermal: the share that a step keeps of what is in no mode

  std::vector<Pull> pulls = {};  ///< steer

  AwayFrom away = AwayFrom::nearest;
  double away_step = 0.01;      ///< away: RMSD of one step away, nm
  double away_spacing = 0.05;   ///< away: least RMSD between conformers that are remembered; the
                                ///< width of the density
  std::vector<int> sites = {};  ///< away, thermal: joints that RMSDs are of; empty: all
  std::vector<int> site_of_joint = {};  ///< away: whose push a joint follows, an index of `sites`,
                                        ///< or -1: none (njoint, or empty: its own)
};

class Motion {
 public:
  virtual ~Motion() = default;

  /// Moves the joints of a step; fixed joints stay.
  /// @param random  addressed by the walker's seed and the number of the step
  virtual void move(std::span<Vec3> positions, Random& random) = 0;

  /// The step was resolved and kept.
  virtual void kept(std::span<const Vec3> /*before*/, std::span<const Vec3> /*after*/) {}

  /// The step was taken back.
  virtual void taken_back() {}

  /// What it remembers; restore() goes on from there, bit for bit.
  virtual std::vector<double> state() const { return {}; }

  /// @throw Error if the state is none of this motion
  virtual void restore(std::span<const double> state);
};

/// Makes a walker's motion, by the walker's seed.
using MotionFactory = std::function<std::unique_ptr<Motion>(std::uint64_t seed)>;

/// What all walkers share (hinges, modes) is made once.
/// @param start  where walkers start, nm (njoint)
/// @throw Error  on settings that make no sense: sizes that are negative, modes that are missing or
///               do not fit the framework, joints that it does not have
MotionFactory motion_factory(std::shared_ptr<const Framework> framework,
                             std::span<const Vec3> start, const MotionSettings& settings);

}  // namespace ragdoll
