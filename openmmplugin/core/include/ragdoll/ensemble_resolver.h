// EnsembleResolver: conformers of one framework resolved side by side, one in each lane of the
// machine's vectors. Lanes do not wait for each other: each is loaded, iterates and is unloaded on
// its own.

#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "ragdoll/resolver.h"  // ResolverSettings, Breakage, ResolveReport

namespace ragdoll {

class EnsembleResolver {
 public:
  virtual ~EnsembleResolver() = default;

  virtual int lanes() const = 0;
  virtual std::size_t joint_count() const = 0;

  /// The instructions that work: "AVX3", "AVX2", ..., or "none" where lanes are resolved in turn.
  virtual std::string instructions() const = 0;

  /// The solver that works: what "auto" chose.
  virtual std::string solver() const = 0;

  /// Puts a break into a lane that is free. What `breakage` points to has to stay until unload.
  /// @param positions  nm (njoint)
  virtual void load(int lane, std::span<const Vec3> positions, const Breakage& breakage) = 0;

  /// One iteration in each lane that is loaded and not done.
  virtual void iterate() = 0;

  /// Whether a loaded lane has ended: resolved or given up.
  virtual bool done(int lane) const = 0;

  /// Frees a lane that is done. Positions and report are those of the single Resolver with the same
  /// settings, bit for bit, whatever the other lanes hold.
  virtual ResolveReport unload(int lane, std::span<Vec3> positions) = 0;
};

/// @param lanes  as many as the machine's vectors hold where 0; 1 or more otherwise
/// @throw Error  as make_resolver does
std::unique_ptr<EnsembleResolver> make_ensemble_resolver(std::shared_ptr<const Framework> framework,
                                                         const ResolverSettings& settings,
                                                         int lanes = 0);

/// Resolves any number of conformers, lanes loaded anew as they become free.
/// @param positions  of one conformer behind the other, nm (nconformer * njoint), changed in place
/// @param first_step  conformer k is the break of step first_step + k
std::vector<ResolveReport> resolve_all(EnsembleResolver& resolver, std::span<Vec3> positions,
                                       std::uint64_t first_step = 0, const Box* box = nullptr);

}  // namespace ragdoll
