// The `newton` solver: Gauss-Seidel, then Levenberg-Marquardt on a sparse LDL^T.

#pragma once
#include <memory>

#include "newton_engine.h"     // NewtonTask, NewtonEnd
#include "ragdoll/resolver.h"  // Resolver, ResolverSettings

namespace ragdoll {

/// A sweep, then Newton steps (J^T J + mu) dx = -J^T r over all constraints at once, on 3x3
/// blocks. A report's iterations are sweeps plus steps, steps that were taken back included; a
/// step's corrections by its own factor are part of it. The orders, the weighting and the roots of
/// the settings play no part; the result depends on the framework, the tolerance and the positions
/// alone. Where the steps lead nowhere - bars that cannot all be met, a centre caught in its mirror
/// image
/// - the neighbourhoods of the worst violations are resolved on their own, shaken (by fixed random
/// numbers). Of these neighbourhoods, which do not wait for each other, the one that took most
/// counts among the iterations, by the try that resolved it; bar visits are of all neighbourhoods
/// and tries. If that does not help, the reason is "stagnated", and the joints stay where the
/// misfit was smallest.
/// With single precision, what floats cannot resolve is finished in doubles; whether all is within
/// tolerance is always measured in doubles. With mass weights, mu and the sweeps hold each joint by
/// its mass.
///
/// Frameworks whose factor would be too large, such as 3-D lattices, take their steps by conjugate
/// gradients, in doubles always; bar visits are of each round of these too.
///
/// Frameworks of bars whose cycles are few take a shorter way first (resolver_newton_bars.h).
std::unique_ptr<Resolver> make_newton_resolver(std::shared_ptr<const Framework> framework,
                                               const ResolverSettings& settings);

/// Without the shorter way.
std::unique_ptr<Resolver> make_general_newton_resolver(std::shared_ptr<const Framework> framework,
                                                       const ResolverSettings& settings);
std::unique_ptr<Resolver> make_newton_resolver(std::shared_ptr<const NewtonTask> task);

std::int64_t bar_visits_of(const NewtonEnd& end, const Framework& framework);

/// Fills the report of an engine's run, whose iterations it knows already. @return false if the
/// run's end is not resolved
bool conclude_newton(const NewtonEnd& end, ResolveReport& report);

}  // namespace ragdoll
