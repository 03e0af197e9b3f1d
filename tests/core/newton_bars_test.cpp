// Tests for core/src/newton_bars*.cpp and resolver_newton_bars.cpp: frameworks of bars whose cycles
// are few.

#include <gtest/gtest.h>

#include <algorithm>  // max
#include <cmath>      // abs, sqrt
#include <limits>
#include <numeric>  // iota

#include "examples.h"
#include "newton_bars_plan.h"
#include "ragdoll/ensemble_resolver.h"  // make_ensemble_resolver, resolve_all
#include "ragdoll/generate.h"           // generate_structure
#include "ragdoll/resolver.h"           // make_resolver
#include "resolver_newton.h"            // make_general_newton_resolver
#include "vector_targets.h"             // for_each_vector_target

namespace ragdoll {
namespace {

using namespace examples;
using Example = examples::Structure;

Random dice(std::uint64_t seed) {
  return Random(seed, RandomStream::generate, 3);
}

ResolverSettings settings_for(Tolerance tolerance, Precision precision = Precision::double_) {
  return {.solver = "newton", .tolerance = tolerance, .precision = precision};
}

/// A chain with a ring of five at every tenth joint and a branch at every third, unit bars.
Example molecule_like(int joints, std::uint64_t seed) {
  Example s;
  Random random = dice(seed);
  const auto place = [&](int at) {
    const Vec3 step(random.gaussian(), random.gaussian(), random.gaussian());
    s.positions.push_back(at < 0 ? Vec3(0, 0, 0) : Vec3(s.positions[std::size_t(at)] + step));
  };
  const auto bar = [&](int p, int q) {
    const double length = (s.positions[std::size_t(q)] - s.positions[std::size_t(p)]).norm();
    s.parts.bars.push_back({p, q, length});
  };
  for (int j = 0; j < joints; ++j) {
    const int to = j % 3 == 2 ? j - 2 : j - 1;
    place(to);
    if (j > 0) bar(to, j);
    if (j % 10 == 9) bar(j, j - 4);
  }
  s.parts.masses.assign(std::size_t(joints), 1.0);
  return s;
}

Positions broken(const Example& s, double sigma, std::uint64_t seed) {
  Positions x = s.positions;
  Random random = dice(100 + seed);
  for (Vec3& point : x)
    point += sigma * Vec3(random.gaussian(), random.gaussian(), random.gaussian());
  return x;
}

/// By a loop of its own.
double worst_of(const FrameworkParts& parts, const Positions& x) {
  double worst = 0;
  for (const Bar& bar : parts.bars) {
    const Vec3 d = x[std::size_t(bar.q)] - x[std::size_t(bar.p)];
    worst = std::max(worst, std::abs(std::sqrt(d.dot(d)) - bar.length) / bar.length);
  }
  return worst;
}

double moved(const Positions& from, const Positions& to) {
  double sum = 0;
  for (std::size_t j = 0; j < from.size(); ++j) sum += (to[j] - from[j]).squaredNorm();
  return std::sqrt(sum);
}

// === The plan

TEST(NewtonBars, TreeIsEliminatedWithoutFillIn) {
  const StructureRequest request = {.class_name = "tree", .joints = 300, .seed = 2};
  const auto framework = framework_of(generate_structure(request).parts);
  const auto plan = NewtonBarsPlan::make(*framework, settings_for(1e-3));
  ASSERT_TRUE(plan);
  std::size_t pairs = 0;  // of bars that share a joint
  for (int j = 0; j < framework->joint_count(); ++j) {
    const std::size_t bars = framework->graph().links(j).size();
    pairs += bars * (bars - 1) / 2;
  }
  EXPECT_EQ(plan->entries.size(), pairs);
  for (const auto& entry : plan->entries) EXPECT_NE(entry.coupling, 0);
}

TEST(NewtonBars, OtherConstraintsAndManyCyclesAreNotForIt) {
  FrameworkParts parts = molecule_like(40, 1).parts;
  const auto plans = [](const FrameworkParts& p) {
    return NewtonBarsPlan::make(*framework_of(p), settings_for(1e-3)) != nullptr;
  };
  EXPECT_TRUE(plans(parts));
  FrameworkParts tethered = parts;
  tethered.tethers.push_back({0, 30, 5});
  EXPECT_FALSE(plans(tethered));
  Random random = dice(3);
  EXPECT_FALSE(plans(random_structure(40, 30, random).parts));
  parts.bars.clear();
  EXPECT_FALSE(plans(parts));
}

// === One conformer

TEST(NewtonBars, EachStepSquaresWhatIsLeft) {
  const Example s = molecule_like(600, 4);
  for (const auto& [tolerance, most] : {std::pair(1e-2, 3), {1e-4, 4}, {1e-8, 5}, {1e-13, 6}}) {
    Positions x = broken(s, 0.05, 1);
    ASSERT_GT(worst_of(s.parts, x), 0.05);
    const auto resolver = make_resolver(framework_of(s.parts), settings_for(tolerance));
    const ResolveReport report = resolver->resolve(x, {});
    EXPECT_TRUE(report.converged);
    EXPECT_LE(report.iterations, most);
    EXPECT_EQ(report.bar_visits, report.iterations * std::int64_t(s.parts.bars.size()));
    EXPECT_LE(worst_of(s.parts, x), tolerance * (1 + 1e-9) + 1e-15);
    EXPECT_NEAR(report.residual, worst_of(s.parts, x), 1e-14);
  }
}

TEST(NewtonBars, JointsMoveAsLittleAsTheGeneralWayMovesThem) {
  const Example s = molecule_like(200, 5);
  for (std::uint64_t k = 0; k < 5; ++k) {
    const Positions start = broken(s, 0.1, k);
    Positions x = start, y = start;
    const auto framework = framework_of(s.parts);
    EXPECT_TRUE(make_resolver(framework, settings_for(1e-6))->resolve(x, {}).converged);
    EXPECT_TRUE(
        make_general_newton_resolver(framework, settings_for(1e-6))->resolve(y, {}).converged);
    EXPECT_LE(moved(start, x), 1.02 * moved(start, y));
  }
}

TEST(NewtonBars, EveryClassIsResolvedWhereverTheForceActs) {
  for (const char* class_name : {"tree", "1-cycle", "2-cycle"})
    for (const Tolerance tolerance : {Tolerance(1e-3), Tolerance::nanometers(1e-6)}) {
      const ragdoll::Structure structure =
          generate_structure({.class_name = class_name, .joints = 40, .seed = 6});
      const ForceSet forces = generate_forces(structure, {.count = 60, .lo = 0.1, .hi = 20});
      const auto resolver = make_resolver(framework_of(structure.parts), settings_for(tolerance));
      Positions x = structure.positions;
      for (const Force& force : forces.forces) {
        x[std::size_t(force.joint)] += force.force;
        const ResolveReport report = resolver->resolve(x, {});
        ASSERT_TRUE(report.converged) << class_name << " " << report.worst;
        for (const Bar& bar : structure.parts.bars) {
          const double d = (x[std::size_t(bar.q)] - x[std::size_t(bar.p)]).norm();
          ASSERT_LE(std::abs(d - bar.length), tolerance.slack(bar.length) * (1 + 1e-9));
        }
      }
    }
}

TEST(NewtonBars, FixedJointsStayAndHeavyOnesMoveLess) {
  Example s = molecule_like(100, 7);
  s.parts.fixed.assign(100, 0);
  s.parts.fixed[0] = s.parts.fixed[50] = 1;
  for (std::size_t j = 0; j < 100; ++j) s.parts.masses[j] = j % 2 == 0 ? 100 : 1;
  ResolverSettings settings = settings_for(1e-8);
  settings.mass_weights = true;
  const Positions start = broken(s, 0.05, 2);
  Positions x = start;
  EXPECT_TRUE(make_resolver(framework_of(s.parts), settings)->resolve(x, {}).converged);
  EXPECT_LE(worst_of(s.parts, x), 1e-8);
  EXPECT_EQ(x[0], start[0]);
  EXPECT_EQ(x[50], start[50]);
  Positions general = start;
  EXPECT_TRUE(make_general_newton_resolver(framework_of(s.parts), settings)
                  ->resolve(general, {})
                  .converged);
  double heavy = 0, light = 0;
  for (std::size_t j = 0; j < 100; ++j) {
    (j % 2 == 0 ? heavy : light) += (x[j] - start[j]).norm();
    EXPECT_LE((x[j] - general[j]).norm(), 1e-3);
  }
  EXPECT_LT(heavy, 0.25 * light);
}

TEST(NewtonBars, WhatTheStepsCannotDoIsLeftToTheGeneralWay) {
  // a triangle that cannot close on a long tail, and positions that are no numbers
  Example s = molecule_like(60, 8);
  s.parts.bars.push_back({58, 59, 100});
  Positions x = broken(s, 0.05, 3);
  const auto resolver = make_resolver(framework_of(s.parts), settings_for(1e-6));
  const ResolveReport report = resolver->resolve(x, {});
  EXPECT_FALSE(report.converged);
  EXPECT_NE(report.worst, "");
  EXPECT_LE(report.iterations, 10000);
  x = s.positions;
  x[5] = Vec3(std::numeric_limits<double>::quiet_NaN(), 0, 0);
  EXPECT_EQ(resolver->resolve(x, {}).reason, StopReason::not_finite);
}

TEST(NewtonBars, MaximumOfIterationsIsKept) {
  const Example s = molecule_like(100, 9);
  for (const long most : {1L, 2L, 3L}) {
    ResolverSettings settings = settings_for(1e-12);
    settings.max_iterations = most;
    const Positions start = broken(s, 0.1, 4);
    Positions x = start;
    const ResolveReport report = make_resolver(framework_of(s.parts), settings)->resolve(x, {});
    EXPECT_FALSE(report.converged);
    EXPECT_EQ(report.reason, StopReason::max_iterations);
    EXPECT_EQ(report.iterations, most);
    EXPECT_NEAR(report.residual, worst_of(s.parts, x), 1e-12);
    EXPECT_LT(worst_of(s.parts, x), worst_of(s.parts, start));
  }
}

TEST(NewtonBars, NothingBrokenMovesNothing) {
  const Example s = molecule_like(100, 10);
  for (const Precision precision : {Precision::double_, Precision::single}) {
    Positions x = s.positions;
    const ResolveReport report =
        make_resolver(framework_of(s.parts), settings_for(1e-3, precision))->resolve(x, {});
    EXPECT_EQ(report.reason, StopReason::nothing_broken);
    EXPECT_EQ(report.iterations, 0);
    EXPECT_EQ(x, s.positions);
  }
}

TEST(NewtonBars, FloatsAreMeasuredInDoublesAndFinishedInThem) {
  const Example s = molecule_like(100, 11);
  for (const double tolerance : {1e-3, 2e-5, 1e-9}) {
    Positions x = broken(s, 0.05, 5);
    for (Vec3& point : x) point += Vec3(1000, -500, 20);
    const ResolveReport report =
        make_resolver(framework_of(s.parts), settings_for(tolerance, Precision::single))
            ->resolve(x, {});
    EXPECT_TRUE(report.converged) << tolerance;
    EXPECT_LE(worst_of(s.parts, x), tolerance * (1 + 1e-9));
    EXPECT_NEAR(report.residual, worst_of(s.parts, x), 1e-12);
  }
}

// === Lanes

TEST(NewtonBars, EachLaneEndsWithTheBitsOfOneAlone) {
  const Example s = molecule_like(120, 12);
  const auto framework = framework_of(s.parts);
  for_each_vector_target([&] {
    for (const Precision precision : {Precision::double_, Precision::single}) {
      const ResolverSettings settings = settings_for(1e-4, precision);
      const auto alone = make_resolver(framework, settings);
      const auto ensemble = make_ensemble_resolver(framework, settings);
      // broken little, much, beyond what steps can do, and not at all
      std::vector<Positions> starts;
      for (std::uint64_t k = 0; k < 37; ++k) {
        const double sigma = k % 7 == 6 ? 0 : k % 7 == 5 ? 3 : 0.03 * double(k % 5 + 1);
        starts.push_back(broken(s, sigma, k));
      }
      Positions all;
      for (const Positions& x : starts) all.insert(all.end(), x.begin(), x.end());
      const std::vector<ResolveReport> reports = resolve_all(*ensemble, all);
      for (std::size_t k = 0; k < starts.size(); ++k) {
        Positions x = starts[k];
        const ResolveReport report = alone->resolve(x, {});
        const auto first = all.begin() + std::ptrdiff_t(k * x.size());
        EXPECT_TRUE(std::equal(x.begin(), x.end(), first)) << k;
        EXPECT_EQ(reports[k].iterations, report.iterations);
        EXPECT_EQ(reports[k].bar_visits, report.bar_visits);
        EXPECT_EQ(reports[k].residual, report.residual);
        EXPECT_EQ(reports[k].reason, report.reason);
        EXPECT_EQ(report.converged, worst_of(s.parts, x) <= 1e-4 * (1 + 1e-9));
      }
    }
  });
}

}  // namespace
}  // namespace ragdoll
