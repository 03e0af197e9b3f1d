#include "ragdoll/force_run.h"

#include <cmath>    // isfinite
#include <utility>  // move, swap

#include "ragdoll/error.h"  // Error

namespace ragdoll {
namespace {

void check(const Framework& framework, const std::vector<Vec3>& positions, const ForceSet& forces) {
  if (int(positions.size()) != framework.joint_count())
    throw Error("there are " + std::to_string(positions.size()) + " positions for " +
                std::to_string(framework.joint_count()) + " joints");
  if (!(forces.timestep > 0) || !std::isfinite(forces.timestep))
    throw Error("the timestep must be a positive number");
  for (std::size_t k = 0; k < forces.forces.size(); ++k) {
    const Force& force = forces.forces[k];
    if (force.joint < 0 || force.joint >= framework.joint_count())
      throw Error("force " + std::to_string(k) + " acts on joint " + std::to_string(force.joint) +
                  ", but there are " + std::to_string(framework.joint_count()));
    if (!force.force.allFinite())
      throw Error("force " + std::to_string(k) + " on " + framework.name(force.joint) +
                  " is not a finite number");
  }
}

/// Moves the joints from x, which they then leave in x_old.
/// @param moved  joints that are not where x_old has them; null: any
void break_by(const Force& force, const Framework& framework, double dt, VerletScope scope,
              const std::vector<int>* moved, std::vector<Vec3>& x, std::vector<Vec3>& x_old,
              std::vector<Vec3>& forces) {
  const auto joint = std::size_t(force.joint);
  const Vec3 was = x[joint];
  forces[joint] = force.force;
  std::vector<Vec3> before;
  if (scope == VerletScope::all || !moved) before = x;
  const std::size_t first = scope == VerletScope::all ? 0 : joint;
  const std::size_t count = scope == VerletScope::all ? x.size() : 1;
  verlet(std::span(x).subspan(first, count), std::span(x_old).subspan(first, count),
         std::span(forces).subspan(first, count),
         std::span(framework.masses()).subspan(first, count),
         std::span(framework.fixed()).subspan(first, count), dt, VerletScope::all);
  forces[joint].setZero();
  if (!before.empty()) {
    x_old = std::move(before);
    return;
  }
  // one force on a large structure costs no copy of it
  for (const int j : *moved) x_old[std::size_t(j)] = x[std::size_t(j)];
  x_old[joint] = was;
}

}  // namespace

std::shared_ptr<const Framework> framework_of(const Structure& structure) {
  FrameworkParts parts = structure.parts;
  if (!structure.ids.empty()) parts.labels = structure.ids;
  return std::make_shared<const Framework>(std::move(parts));
}

ForceRun run_forces(const Structure& structure, const ForceSet& forces,
                    const ForceRunSettings& settings) {
  return run_forces(framework_of(structure), structure.positions, forces, settings);
}

ForceRun run_forces(std::shared_ptr<const Framework> framework, const std::vector<Vec3>& positions,
                    const ForceSet& forces, const ForceRunSettings& settings) {
  check(*framework, positions, forces);
  ResolverSettings resolver_settings = settings.resolver;
  resolver_settings.tolerance = settings.tolerance.value_or(forces.tolerance);
  resolver_settings.max_iterations = forces.max_iterations;
  const std::unique_ptr<Resolver> resolver = make_resolver(framework, resolver_settings);

  ForceRun run;
  run.positions = positions;
  std::vector<Vec3> x_old = positions, acting(positions.size(), Vec3::Zero());
  const std::vector<int> none;
  for (std::size_t k = 0; k < forces.forces.size(); ++k) {
    const Force& force = forces.forces[k];
    break_by(force, *framework, forces.timestep, settings.verlet,
             k > 0 ? resolver->moved_joints() : &none, run.positions, x_old, acting);
    const int root = force.joint;
    const bool only_root_moved =
        k > 0 && run.reports.back().converged && settings.verlet == VerletScope::affected;
    run.reports.push_back(resolver->resolve(
        run.positions, {.roots = {&root, 1}, .step = k, .only_roots_moved = only_root_moved}));
    if (settings.frames) run.frames.push_back(run.positions);
    if (settings.progress && !settings.progress(k + 1)) break;
  }
  // what "auto" chose depends on what was broken
  run.solver = resolver->solver();
  return run;
}

}  // namespace ragdoll
