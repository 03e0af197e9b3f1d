// The `block` solver: one ordered sweep over bridges and cycle blocks.

#pragma once
#include <memory>

#include "ragdoll/resolver.h"  // Resolver, ResolverSettings

namespace ragdoll {

/// @throw Error  on tethers, contacts and volumes: it holds bars only
std::unique_ptr<Resolver> make_block_resolver(std::shared_ptr<const Framework> framework,
                                              const ResolverSettings& settings);

}  // namespace ragdoll
