// NewtonEngine: sweeps and Newton steps of one or more conformers side by side. Private to the
// solver `newton`.

#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "newton_plan.h"       // NewtonPlan
#include "ragdoll/resolver.h"  // ResolverSettings, StopReason

namespace ragdoll {

/// Where a conformer came to.
struct NewtonEnd {
  StopReason reason = StopReason::nothing_broken;
  std::int64_t iterations = 0;
  double residual = 0, residual_nm = 0;  ///< largest violations, as a ResolveReport has them
  double energy = 0;                     ///< half the sum of the squared rows, nm^2
  std::int64_t passes = 0;               ///< over all rows, within steps
};

/// A Gauss-Seidel sweep, then Levenberg-Marquardt: (J^T J + mu) dx = -J^T r over all constraints.
/// Volumes that the bars leave one value are pulled there, within their bounds too: bars alone
/// hardly feel a joint that leaves the plane of the others, so that their steps converge but
/// linearly there, and from afar to the mirror image. Where that leads nowhere, as bars that cannot
/// all be met may have it, volumes are held by their bounds alone. What a step leaves behind, of
/// second order, is taken away by the same factor where that ends it (not by floats, whose lanes
/// wait for memory).
/// Each lane has its own mu and decides on its own steps; what it does depends on
/// nothing in other lanes, nor on how many there are.
class NewtonEngine {
 public:
  virtual ~NewtonEngine() = default;

  virtual int lanes() const = 0;
  /// @param max_iterations  1 or more
  virtual void load(int lane, std::span<const Vec3> positions, const Box* box,
                    std::int64_t max_iterations) = 0;
  virtual void iterate() = 0;
  virtual bool done(int lane) const = 0;

  /// Where the reason is not_finite or nothing_broken, or a joint is fixed, positions are not
  /// written. What is said to be within tolerance is so, measured in doubles.
  virtual NewtonEnd unload(int lane, std::span<Vec3> positions) = 0;
};

/// What an engine is made for; shared by those of one resolver.
struct NewtonTask {
  /// @param whole  as NewtonPlan has it
  NewtonTask(std::shared_ptr<const Framework> framework, const ResolverSettings& settings,
             std::optional<double> most_products = {}, bool whole = false);
  std::shared_ptr<const Framework> framework;
  ResolverSettings settings;
  NewtonPlan plan;
};

/// One conformer, or as many as a vector holds, by the best instructions that the machine has.
/// Where the plan is bulky: one conformer, in doubles.
/// @param precision  of the numbers inside
std::unique_ptr<NewtonEngine> make_newton_engine(std::shared_ptr<const NewtonTask> task,
                                                 Precision precision, bool single);

/// "AVX3", "AVX2", ...
std::string newton_instructions();

}  // namespace ragdoll
