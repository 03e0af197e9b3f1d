// The solver "templates": see resolver_templates.cpp.

#pragma once
#include <memory>

#include "ragdoll/resolver.h"  // Resolver, ResolverSettings

namespace ragdoll {

std::unique_ptr<Resolver> make_templates_resolver(std::shared_ptr<const Framework> framework,
                                                  const ResolverSettings& settings);

}  // namespace ragdoll
