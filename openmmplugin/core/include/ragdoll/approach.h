// Approach: a path from one conformation towards another, every frame within the constraints.

#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "ragdoll/backbone_guide.h"  // BackboneGuide
#include "ragdoll/box.h"             // Box
#include "ragdoll/motion.h"          // MotionSettings
#include "ragdoll/resolver.h"        // ResolverSettings, ResolveReport

namespace ragdoll {

struct ApproachSettings {
  ResolverSettings resolver;
  std::vector<int> joints;  ///< that have a target (ntarget)
  /// Where they are to be, as a whole anywhere; with fixed joints right there. nm (ntarget)
  std::vector<Vec3> target;
  /// Weights of the targets in the RMSD that is lowered; a stage begins where the one before it
  /// comes no further (nstage, ntarget).
  std::vector<std::vector<double>> stages;
  std::vector<int> sites;  ///< targets that tell how near it is, such as CA: indices of `joints`

  double step = 0.01;        ///< by which the cap on the RMSD is lowered at a time, nm
  double least_step = 2e-4;  ///< below it a stage comes no further, nm
  double site_step = 0.025;  ///< the most that a step may ask of a site, nm
  double spacing = 0.03;     ///< a frame is due when a site has moved so far since the last, nm
  double widest = 0.05;      ///< and no site moves further from one frame to the next, nm
  double close = 0.005;      ///< RMSD of the sites at which the path ends, nm
  double arrived = 0.02;     ///< RMSD of the sites at which it has arrived, nm
  int retries = 12;          ///< random moves, each followed by a new try, where it is stuck

  /// Leads residues to where they are plausible; null: none.
  std::shared_ptr<const BackboneGuide> guide = {};
  /// Pairs that start closer than the contact rule allows move apart on the way, and stay apart.
  bool part_close_pairs = true;
  std::size_t mended_stages = 0;  ///< in which the guide and the parting work, from the first on

  bool wander = false;  ///< random moves in every step: another path for each seed
  MotionSettings motion = {.kind = MotionKind::momentum};  ///< of random moves
};

struct ApproachFrame {
  std::int64_t number = 0, steps = 0;
  double rmsd = 0;              ///< of the sites, superposed but with fixed joints, nm
  double target_rmsd = 0;       ///< of all targets, the same, nm
  ResolveReport report = {};    ///< of the step that made it
  std::vector<Vec3> positions;  ///< nm (njoint)
};

struct ApproachReport {
  double rmsd_start = 0, rmsd_end = 0;  ///< of the sites, nm
  double target_rmsd_end = 0;           ///< of all targets, nm
  std::int64_t frames = 0, steps = 0, rejected_steps = 0, retries = 0;
  std::vector<std::int64_t> iterations = {};  ///< of each step
  std::string solver = {};
  std::string last_rejection = {};
  bool arrived = false, interrupted = false;
};

/// Lowers a cap on the RMSD from the target step by step. A step projects on the cap: after
/// superposition each target moves by (1 - cap / RMSD) of its way, and joints without a target
/// follow the nearest one along the bonds; then all constraints are resolved. That is the move of
/// least work, in the sense of least squares. A step that cannot be resolved, or comes no nearer,
/// is taken back and halved; where that ends, random moves shake the structure, and the cap comes
/// down again from where that leads. Frames are given out in turn, each nearer than the one before;
/// the start is not among them, and the last is the nearest that was reached. With fixed joints
/// nothing is superposed: these stay, the others come to their targets' places.
/// @param keep_going  asked before each step; false: the path ends here
/// @throw Error on sizes that disagree, and as make_resolver and motion_factory do
ApproachReport approach(std::shared_ptr<const Framework> framework, std::span<const Vec3> start,
                        const ApproachSettings& settings, const Box* box,
                        const std::function<void(const ApproachFrame&)>& take,
                        const std::function<bool()>& keep_going = {});

}  // namespace ragdoll
