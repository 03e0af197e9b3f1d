#include "ragdoll/break.h"

#include <algorithm>  // min
#include <array>
#include <utility>

#include "names.h"          // value_of
#include "ragdoll/error.h"  // Error

namespace ragdoll {
namespace {

constexpr std::array<std::pair<VerletScope, const char*>, 2> scopes = {{
    {VerletScope::affected, "affected"},
    {VerletScope::all, "all"},
}};

constexpr std::array<std::pair<PerturbationKind, const char*>, 3> kinds = {{
    {PerturbationKind::none, "none"},
    {PerturbationKind::gaussian, "gaussian"},
    {PerturbationKind::ball, "ball"},
}};

/// Uniform in the unit ball: a direction by rejection from the cube.
Vec3 point_in_ball(Random& random) {
  while (true) {
    const double x = 2 * random.uniform() - 1;
    const double y = 2 * random.uniform() - 1;
    const double z = 2 * random.uniform() - 1;
    const Vec3 point(x, y, z);
    if (point.squaredNorm() <= 1) return point;
  }
}

}  // namespace

VerletScope verlet_scope(const std::string& name) {
  return value_of(scopes, name, "Verlet scope");
}
std::string name_of(VerletScope scope) {
  return name_in(scopes, scope);
}
PerturbationKind perturbation_kind(const std::string& name) {
  return value_of(kinds, name, "perturbation");
}
std::string name_of(PerturbationKind kind) {
  return name_in(kinds, kind);
}

void verlet(std::span<Vec3> positions, std::span<const Vec3> previous, std::span<const Vec3> forces,
            std::span<const double> masses, std::span<const std::uint8_t> fixed, double dt,
            VerletScope scope) {
  for (std::size_t j = 0; j < positions.size(); ++j) {
    if (fixed[j] || masses[j] == 0) continue;
    if (scope == VerletScope::affected && forces[j].isZero(0)) continue;
    positions[j] = 2 * positions[j] - previous[j] + forces[j] * (dt * dt / masses[j]);
  }
}

void perturb(std::span<Vec3> positions, std::span<const std::uint8_t> fixed, PerturbationKind kind,
             double size, Random& random) {
  // fixed joints draw too, so that pinning one leaves the others' numbers as they were
  if (kind == PerturbationKind::ball) {
    for (std::size_t j = 0; j < positions.size(); ++j) {
      const Vec3 move = point_in_ball(random);
      if (!fixed[j]) positions[j] += size * move;
    }
  } else if (kind == PerturbationKind::gaussian) {
    constexpr std::size_t at_once = 128;
    std::array<double, 3 * at_once> moves;
    for (std::size_t first = 0; first < positions.size(); first += at_once) {
      const std::size_t count = std::min(at_once, positions.size() - first);
      random.fill_normal(std::span(moves).first(3 * count));
      for (std::size_t j = 0; j < count; ++j)
        if (!fixed[first + j])
          positions[first + j] += size * Vec3(moves[3 * j], moves[3 * j + 1], moves[3 * j + 2]);
    }
  }
}

}  // namespace ragdoll
