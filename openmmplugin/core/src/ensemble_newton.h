// The lanes of solver `newton`.

#pragma once
#include <memory>

#include "newton_engine.h"              // NewtonTask
#include "ragdoll/ensemble_resolver.h"  // EnsembleResolver, ResolverSettings

namespace ragdoll {

/// @param lanes  0: as many as a vector holds
std::unique_ptr<EnsembleResolver> make_newton_ensemble(std::shared_ptr<const Framework> framework,
                                                       const ResolverSettings& settings, int lanes);

/// Without the shorter way (resolver_newton.h).
std::unique_ptr<EnsembleResolver> make_newton_ensemble(std::shared_ptr<const NewtonTask> task,
                                                       int lanes);

}  // namespace ragdoll
