// Settings: resolvers' settings, boxes and reports as Python gives and gets them.

#pragma once
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include <cstdint>
#include <optional>
#include <string>

#include "arrays.h"            // InPoints
#include "ragdoll/box.h"       // Box
#include "ragdoll/error.h"     // Error
#include "ragdoll/resolver.h"  // ResolverSettings, ResolveReport

namespace ragdoll::bindings {

/// One of both, or the default. @param absolute nm
inline Tolerance tolerance_of(std::optional<double> relative, std::optional<double> absolute) {
  if (relative && absolute) throw Error("give a relative tolerance or an absolute one, not both");
  if (absolute) return Tolerance::nanometers(*absolute);
  return relative ? Tolerance(*relative) : ResolverSettings{}.tolerance;
}

inline ResolverSettings settings_of(const std::string& solver, const std::string& order,
                                    const std::string& weighting, std::optional<double> tolerance,
                                    std::optional<double> absolute_tolerance, long max_iterations,
                                    std::uint64_t seed, const std::string& precision,
                                    bool mass_weights) {
  ResolverSettings settings;
  settings.solver = solver;
  settings.order = order_kind(order);
  settings.weighting = weighting_of(weighting);
  settings.tolerance = tolerance_of(tolerance, absolute_tolerance);
  settings.max_iterations = max_iterations;
  settings.seed = seed;
  settings.precision = precision_of(precision);
  settings.mass_weights = mass_weights;
  return settings;
}

inline std::optional<Box> box_of(const std::optional<InPoints>& vectors) {
  if (!vectors) return std::nullopt;
  const std::vector<Vec3> rows = points_of(*vectors);
  if (rows.size() != 3) throw Error("a box is three vectors");
  return Box{rows[0], rows[1], rows[2]};
}

inline nb::dict report_dict(const ResolveReport& report) {
  nb::dict d;
  d["converged"] = report.converged;
  d["iterations"] = report.iterations;
  d["bar_visits"] = report.bar_visits;
  d["carried"] = report.carried;
  d["residual"] = report.residual;
  d["residual_nm"] = report.residual_nm;
  d["reason"] = name_of(report.reason);
  d["worst"] = report.worst;
  return d;
}

}  // namespace ragdoll::bindings
