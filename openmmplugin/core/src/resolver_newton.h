// The `newton` solver: Gauss-Seidel, then Levenberg-Marquardt on a sparse LDL^T.

#pragma once
#include <memory>

#include "ragdoll/resolver.h"  // Resolver, ResolverSettings

namespace ragdoll {

/// Two sweeps, then Newton steps (J^T J + mu) dx = -J^T r over all constraints at once, on 3x3
/// blocks. A report's iterations are sweeps plus steps, steps that were taken back included, and
/// each visits every bar. The orders, the weighting and the roots of the settings play no part; the
/// result depends on the framework, the tolerance and the positions alone.
/// Where the steps lead nowhere - bars that cannot all be met, a centre caught in its mirror image
/// - the violated neighbourhood is shaken a few times (by fixed random numbers); if that does not
/// help, the reason is "stagnated", and the joints stay where the misfit was smallest.
std::unique_ptr<Resolver> make_newton_resolver(std::shared_ptr<const Framework> framework,
                                               const ResolverSettings& settings);

}  // namespace ragdoll
