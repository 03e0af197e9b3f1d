// The `auto` solver: chooses among the others by the structure and by what broke.

#pragma once
#include <memory>
#include <string>

#include "ragdoll/resolver.h"  // Resolver, ResolverSettings

namespace ragdoll {

/// What `auto` takes for a break of all joints, or of forced ones. Constraints of any kind couple
/// components, and what is coupled is resolved by one solver; where pieces want different ones, all
/// are told: "block (3 components), newton (1 component)". It depends on nothing else, so that a
/// run can be repeated.
std::string automatic_solver(const Framework& framework, const ResolverSettings& settings,
                             bool all_moved);

/// Pieces that want the same solver are resolved together. Its solver() tells what worked last, and
/// before the first break what a break of all joints will get.
std::unique_ptr<Resolver> make_automatic_resolver(std::shared_ptr<const Framework> framework,
                                                  const ResolverSettings& settings);

}  // namespace ragdoll
