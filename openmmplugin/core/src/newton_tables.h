// NewtonTables: a plan's constraints as its kernel reads them. Private to the solver `newton`.

#pragma once
#include <algorithm>  // max
#include <cmath>      // cbrt, isfinite
#include <limits>     // epsilon
#include <vector>

#include "newton_plan.h"       // NewtonPlan
#include "ragdoll/resolver.h"  // ResolverSettings

namespace ragdoll {

/// What the tolerance is short by, so that rounding does not break what is just within it.
constexpr double newton_margin = 32;  // epsilons

/// As numbers of type T.
template <class T>
struct NewtonTables {
  struct Pair {
    int p, q;
    T side, length, inverse_length, slack, share_p, share_q;
  };
  struct Corners {
    int slot[4];
    T lower, upper, slack, inverse_scale, inverse_area;
    T pulled, aim;  ///< whether (1 or 0) the bars leave it one value, and that
    int mirror;     ///< whose sign the aim has; -1: its own
    T share[4];     ///< how readily each corner moves
  };
  std::vector<Pair> pairs, far;
  std::vector<Corners> volumes;
  std::vector<T> masses;  ///< by slot: what mu is multiplied by
};

template <class T>
NewtonTables<T> make_newton_tables(const NewtonPlan& plan, const ResolverSettings& settings) {
  NewtonTables<T> tables;
  const bool weighted = settings.mass_weights;
  for (int s = 0; s < plan.joints; ++s)
    tables.masses.push_back(weighted ? T(std::max(plan.masses[std::size_t(s)], 1e-6)) : T(1));
  const auto readiness = [&](int slot) {
    return slot < plan.moving ? 1 / double(tables.masses[std::size_t(slot)]) : 0.0;
  };
  const double epsilon = double(std::numeric_limits<T>::epsilon());
  const auto table_of = [&](const NewtonPlan::Pair& pair) -> typename NewtonTables<T>::Pair {
    const double p = readiness(pair.p), q = readiness(pair.q);
    const double slack = settings.tolerance.slack(pair.length);
    return {pair.p,
            pair.q,
            T(pair.side),
            T(pair.length),
            T(1 / pair.length),
            T(std::max(slack - newton_margin * epsilon * pair.length, slack / 2)),
            p > 0 ? T(p / (p + q)) : T(0),
            q > 0 ? T(q / (p + q)) : T(0)};
  };
  for (const NewtonPlan::Pair& pair : plan.pairs) tables.pairs.push_back(table_of(pair));
  for (const NewtonPlan::Pair& pair : plan.far) tables.far.push_back(table_of(pair));
  for (const NewtonPlan::Corners& v : plan.volumes) {
    typename NewtonTables<T>::Corners corners{};
    const double edge = std::cbrt(v.scale);
    for (std::size_t i = 0; i < 4; ++i) {
      corners.slot[i] = v.slot[i];
      corners.share[i] = T(readiness(v.slot[i]));
    }
    const double slack = settings.tolerance.volume_slack(v.scale);
    corners.slack = T(std::max(slack - newton_margin * epsilon * v.scale, slack / 2));
    corners.lower = T(v.lower);
    corners.upper = T(v.upper);
    corners.pulled = std::isfinite(v.aim);
    corners.aim = std::isfinite(v.aim) ? T(v.aim) : T(0);
    corners.mirror = v.mirror;
    corners.inverse_scale = T(1 / v.scale);
    corners.inverse_area = T(1 / (edge * edge));
    tables.volumes.push_back(corners);
  }
  return tables;
}

}  // namespace ragdoll
