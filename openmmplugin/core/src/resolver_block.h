// The `block` solver: one ordered sweep over bridges and cycle blocks.

#pragma once
#include <memory>

#include "ragdoll/resolver.h"  // Resolver, ResolverSettings

namespace ragdoll {

/// Bars by one sweep outward from the forced joint. Where the framework has tethers, contacts or
/// volumes, `newton` finishes what the sweep left; a break of all joints is its alone then.
std::unique_ptr<Resolver> make_block_resolver(std::shared_ptr<const Framework> framework,
                                              const ResolverSettings& settings);

}  // namespace ragdoll
