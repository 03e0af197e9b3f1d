// What the tests of the block solver share.

#pragma once
#include <algorithm>  // max
#include <cmath>      // abs, sqrt
#include <memory>
#include <vector>

#include "examples.h"
#include "ragdoll/force_run.h"  // framework_of
#include "ragdoll/generate.h"   // generate_structure, generate_forces
#include "ragdoll/resolver.h"   // make_resolver

namespace ragdoll::block_examples {

using examples::parts_of;
using examples::Positions;

inline std::unique_ptr<Resolver> block(const FrameworkParts& parts, double tolerance = 1e-6,
                                       long max_iterations = 10000) {
  return make_resolver(
      examples::framework_of(parts),
      {.solver = "block", .tolerance = tolerance, .max_iterations = max_iterations});
}

inline ResolveReport resolve(const FrameworkParts& parts, Positions& x,
                             const std::vector<int>& roots = {}, double tolerance = 1e-6) {
  return block(parts, tolerance)->resolve(x, {.roots = roots});
}

/// By a loop of its own, not by the solver's.
inline double worst_of(const std::vector<Bar>& bars, const Positions& x) {
  double worst = 0;
  for (const Bar& bar : bars) {
    const Vec3 d = x[std::size_t(bar.q)] - x[std::size_t(bar.p)];
    worst = std::max(worst, std::abs(std::sqrt(d.dot(d)) - bar.length) / bar.length);
  }
  return worst;
}

/// A spine of bars of length 1 with a tooth at each joint.
inline Structure caterpillar(int spine) {
  Structure s;
  s.parts.masses.assign(2 * std::size_t(spine), 1);
  for (int j = 0; j < spine; ++j) {
    s.positions.emplace_back(0.8 * j, 0.6 * (j % 2), 0);
    s.positions.emplace_back(0.8 * j, 0.6 * (j % 2), j % 3 == 0 ? 1 : -1);
    if (j > 0) s.parts.bars.push_back({2 * j - 2, 2 * j, 1});
    s.parts.bars.push_back({2 * j, 2 * j + 1, 1});
  }
  return s;
}

inline const StructureRequest classes[] = {
    {.class_name = "tree", .joints = 30},
    {.class_name = "1-cycle", .joints = 30},
    {.class_name = "2-cycle", .type = "path", .joints = 30},
    {.class_name = "2-cycle", .type = "shared-joint", .joints = 30},
    {.class_name = "2-cycle", .type = "theta", .joints = 30},
    {.class_name = "n-cycle", .cycles = 6, .joints = 30},
    {.class_name = "ring-chain", .cycles = 6, .joints = 30},
    {.class_name = "grid", .joints = 16, .dimensions = 2},
    {.class_name = "grid", .joints = 18, .dimensions = 3},
    {.class_name = "cloth", .joints = 16},
};

}  // namespace ragdoll::block_examples
