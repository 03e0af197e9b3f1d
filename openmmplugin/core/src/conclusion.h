// Conclusion: the closing lines of every solver, how far the constraints are still violated and
// which is the worst. Private to the resolvers.

#pragma once
#include <span>

#include "ragdoll/contact_list.h"  // NearPair
#include "ragdoll/resolver.h"      // ResolveReport, StopReason, Tolerance
#include "residual.h"              // Residual

namespace ragdoll {

/// @param near  the pairs of the contact rule that could be violated
Residual residual_of(const Framework& framework, std::span<const Vec3> positions, const Box* box,
                     const Tolerance& tolerance, std::span<const NearPair> near = {});

/// Fills in how it ended. Where it is not resolved the worst constraint is looked for and named.
/// @param residual  at the positions; what is not resolved is measured anew
void conclude(ResolveReport& report, StopReason reason, const Framework& framework,
              std::span<const Vec3> positions, const Box* box, const Tolerance& tolerance,
              const Residual& residual);

inline bool is_resolved(StopReason reason) {
  return reason == StopReason::nothing_broken || reason == StopReason::within_tolerance;
}

}  // namespace ragdoll
