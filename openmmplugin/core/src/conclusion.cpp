#include "conclusion.h"

namespace ragdoll {

Residual residual_of(const Framework& framework, std::span<const Vec3> positions, const Box* box,
                     const Tolerance& tolerance, std::span<const NearPair> near) {
  const auto at = [&](int joint) -> const Vec3& { return positions[std::size_t(joint)]; };
  return residual_of(framework, framework.bars(), at, at, box, tolerance, near);
}

void conclude(ResolveReport& report, StopReason reason, const Framework& framework,
              std::span<const Vec3> positions, const Box* box, const Tolerance& tolerance,
              const Residual& residual) {
  report.reason = reason;
  report.converged = is_resolved(reason);
  if (report.converged) {
    report.residual = residual.relative;
    report.residual_nm = residual.nanometers;
  } else {
    const Violation worst = worst_violation(framework, positions, box, tolerance);
    report.residual = worst.relative;
    report.residual_nm = worst.nanometers;
    report.worst = worst.what;
  }
}

}  // namespace ragdoll
