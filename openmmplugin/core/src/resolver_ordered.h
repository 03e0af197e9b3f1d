// The `ordered` solver: the thesis' sweep.

#pragma once
#include <memory>

#include "ragdoll/resolver.h"  // Resolver, ResolverSettings

namespace ragdoll {

std::unique_ptr<Resolver> make_ordered_resolver(std::shared_ptr<const Framework> framework,
                                                const ResolverSettings& settings);

}  // namespace ragdoll
