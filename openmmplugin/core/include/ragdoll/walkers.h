// Walkers: independent random walks of one framework, side by side in the lanes of ensembles and on
// threads. What one of them does follows from its seed alone.

#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "ragdoll/motion.h"          // MotionSettings
#include "ragdoll/quality_limits.h"  // QualityJudge
#include "ragdoll/resolver.h"        // ResolverSettings, ResolveReport
#include "ragdoll/symmetry.h"        // Symmetry

namespace ragdoll {

/// Where a walker is, and all that its next steps depend on.
struct WalkerState {
  std::vector<Vec3> positions;  ///< after the last step that was kept, nm (njoint)
  std::int64_t steps = 0;       ///< taken, rejected ones included
  std::int64_t accepted = 0;
  std::vector<double> motion = {};  ///< Motion::state()
};

struct WalkSettings {
  ResolverSettings resolver = {};  ///< its seed is that of walker 0; walker k has seed + k
  MotionSettings motion = {};
  /// Copies that move alike; null: none. Resolvers then work to half the tolerance, so that what is
  /// symmetric again can be within it.
  std::shared_ptr<const Symmetry> symmetry = {};
  /// Where walkers go on from, with the settings of the walk that left them there (nwalker); empty:
  /// all begin at the start.
  std::vector<WalkerState> states = {};
  int walkers = 1;             ///< how many
  std::int64_t frames = 1;     ///< of each walker
  std::int64_t stride = 1;     ///< accepted steps from one frame to the next
  std::int64_t attempts = 10;  ///< steps at most for each accepted step that the frames need
  int threads = 0;             ///< at most; 0: as many as there are cores
  int lanes = 0;               ///< of each ensemble; 0: as many as the machine's vectors hold
  /// Frames below its limits are counted and not given out; the walker goes on. Null: none are.
  std::shared_ptr<const QualityJudge> judge = {};
  /// A walker is never further ahead of the frame that is given out next than by `frames_ahead`
  /// frames; nor do frames that wait for their turn take more than `waiting_bytes`, or one frame of
  /// each walker.
  std::int64_t frames_ahead = 64;
  std::size_t waiting_bytes = std::size_t{256} << 20;
};

/// A frame: where a walker is after `stride` more accepted steps.
struct WalkFrame {
  int walker = 0;
  std::int64_t number = 0;      ///< of the walker's frames, from 0
  std::int64_t steps = 0;       ///< that the walker has taken ever, rejected ones included
  ResolveReport report = {};    ///< of the last step
  std::vector<Vec3> positions;  ///< nm (njoint)
};

/// What one walker did.
struct WalkerReport {
  std::uint64_t seed = 0;
  std::int64_t frames = 0;
  std::int64_t steps = 0, rejected_steps = 0;
  std::vector<std::int64_t> iterations = {};            ///< of each step (nstep)
  std::string last_rejection = {};                      ///< why; empty where none was
  std::map<std::string, std::int64_t> low_frames = {};  ///< that the judge refused, by measure
  std::string last_fault = {};                          ///< of these; empty where none was
  WalkerState state = {};                               ///< where it can go on from
};

struct WalkReport {
  std::vector<WalkerReport> walkers;  ///< (nwalker)
  std::string solver;                 ///< that worked
  std::string instructions;           ///< that lanes were resolved with; "none": in turn
  int lanes = 0, threads = 0;         ///< that worked
  bool interrupted = false;
};

/// Every walker starts at `start`, or where a walk before left it. A step moves the joints, by
/// random numbers addressed by the walker's seed and the number of its step, and resolves them; one
/// that does not converge, or inverts a centre, is taken back, and the next step draws anew. With
/// gaussian and ball motions these are the steps of a RagdollIntegrator with
/// setRejectUnresolved(true), bit for bit, whatever the lanes, the threads and the other walkers
/// are. Massless joints do not move.
///
/// Frames come in a fixed order: frame 0 of each walker, then frame 1, and so on; a walker whose
/// steps are used up has no more. A walker does not run further ahead than the frames that may wait
/// for their turn allow.
/// @param start      nm (njoint)
/// @param take       called with each frame, in the calling thread
/// @param keep_going called in the calling thread now and then; false: steps that have begun are
///                   ended, the frames that wait are given out, and the report says `interrupted`
/// @throw Error as make_ensemble_resolver does, and on settings or sizes that make no sense; and
///              whatever the functions throw
WalkReport walk(std::shared_ptr<const Framework> framework, std::span<const Vec3> start,
                const WalkSettings& settings, const Box* box,
                const std::function<void(const WalkFrame&)>& take,
                const std::function<bool()>& keep_going = {});

}  // namespace ragdoll
