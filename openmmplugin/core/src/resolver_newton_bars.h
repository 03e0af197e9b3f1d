// What `newton` does for frameworks of bars whose cycles are few: steps on the bars' multipliers.

#pragma once
#include <memory>

#include "newton_bars_plan.h"           // NewtonBarsPlan
#include "ragdoll/ensemble_resolver.h"  // EnsembleResolver
#include "ragdoll/resolver.h"           // Resolver, ResolverSettings

namespace ragdoll {

/// The plan, where it is to be used; else null.
std::shared_ptr<const NewtonBarsPlan> plan_newton_bars(const Framework& framework,
                                                       const ResolverSettings& settings);

/// Where a few steps do not resolve a break, `newton` for all frameworks starts from where it was;
/// the steps that were tried count among its iterations.
std::unique_ptr<Resolver> make_newton_bars_resolver(std::shared_ptr<const Framework> framework,
                                                    const ResolverSettings& settings,
                                                    std::shared_ptr<const NewtonBarsPlan> plan);

/// Each lane is the resolver's, bit for bit.
std::unique_ptr<EnsembleResolver> make_newton_bars_ensemble(
    std::shared_ptr<const Framework> framework, const ResolverSettings& settings,
    std::shared_ptr<const NewtonBarsPlan> plan, int lanes);

}  // namespace ragdoll
