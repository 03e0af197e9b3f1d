// The lanes of solver `ordered`.

#pragma once
#include <memory>

#include "ragdoll/ensemble_resolver.h"  // EnsembleResolver, ResolverSettings

namespace ragdoll {

/// Whether lanes can do what the settings ask for: an order that stays, the same in all lanes.
bool ordered_lanes_fit(const ResolverSettings& settings);

/// @param alone  the Resolver with these settings, for what lanes cannot do
/// @param lanes  0: as many as suit the machine
std::unique_ptr<EnsembleResolver> make_ordered_ensemble(std::shared_ptr<const Framework> framework,
                                                        const ResolverSettings& settings, int lanes,
                                                        std::unique_ptr<Resolver> alone);

}  // namespace ragdoll
