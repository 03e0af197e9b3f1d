// Tests for core/src/newton_gradients-inl.h: solver `newton` without a factor.

#include <gtest/gtest.h>

#include <algorithm>  // all_of
#include <cmath>      // abs, sin
#include <limits>
#include <optional>

#include "ensemble_newton.h"  // make_newton_ensemble
#include "examples.h"
#include "newton_engine.h"              // NewtonTask
#include "ragdoll/ensemble_resolver.h"  // resolve_all
#include "ragdoll/generate.h"           // generate_structure
#include "ragdoll/resolver.h"           // make_resolver
#include "resolver_newton.h"            // make_newton_resolver
#include "vector_targets.h"             // for_each_vector_target

namespace ragdoll {
namespace {

using namespace examples;
using Example = examples::Structure;

constexpr double infinity = std::numeric_limits<double>::infinity();

/// @param most_products  by default any factor would take too many
std::shared_ptr<const NewtonTask> task_of(const FrameworkParts& parts,
                                          const ResolverSettings& settings,
                                          std::optional<double> most_products = -1) {
  return std::make_shared<const NewtonTask>(framework_of(parts), settings, most_products);
}

ResolveReport resolve(const FrameworkParts& parts, Positions& x, const ResolverSettings& settings,
                      const Box* box = nullptr) {
  const auto task = task_of(parts, settings);
  EXPECT_TRUE(task->plan.is_bulky);
  return make_newton_resolver(task)->resolve(x, {.box = box});
}

double worst_of(const FrameworkParts& parts, const Positions& x) {
  return worst_violation(Framework(parts), x, nullptr).relative;
}

bool finite(const Positions& x) {
  return std::all_of(x.begin(), x.end(), [](const Vec3& point) { return point.allFinite(); });
}

void perturb(Positions& x, double size, Random& random) {
  for (Vec3& point : x) point += size * random_vector(random);
}

Random dice(std::uint64_t seed) {
  return Random(seed, RandomStream::generate, 2);
}

/// A lattice of cubes, 1 apart.
Example lattice(int joints) {
  StructureRequest request;
  request.class_name = "grid";
  request.dimensions = 3;
  request.joints = joints;
  ragdoll::Structure s = generate_structure(request);
  return {s.parts, Positions(s.positions.begin(), s.positions.end())};
}

/// A coil of joints, each held to the next four, chiral, with tethers and contacts across its
/// turns: its shape leaves little choice.
Example coil(int joints) {
  Example s;
  for (int k = 0; k < joints; ++k)
    s.positions.emplace_back(0.25 * std::cos(0.9 * k), 0.25 * std::sin(0.9 * k), 0.05 * k);
  s.parts.masses.assign(s.positions.size(), 12);
  const auto distance = [&s](int p, int q) {
    return (s.positions[std::size_t(p)] - s.positions[std::size_t(q)]).norm();
  };
  for (int p = 0; p < joints; ++p) {
    for (int q = p + 1; q <= p + 4 && q < joints; ++q)
      s.parts.bars.push_back({p, q, distance(p, q)});
    if (p + 7 >= joints) continue;
    if (p % 3 == 0) s.parts.tethers.push_back({p, p + 7, distance(p, p + 7)});
    if (p % 3 == 1) s.parts.contacts.push_back({p, p + 7, distance(p, p + 7)});
    const std::size_t j = std::size_t(p);
    const double volume =
        signed_volume(s.positions[j], s.positions[j + 1], s.positions[j + 2], s.positions[j + 3]);
    s.parts.volumes.push_back({p, p + 1, p + 2, p + 3, volume > 0 ? volume / 2 : -infinity,
                               volume > 0 ? infinity : volume / 2, std::abs(volume)});
  }
  return s;
}

ContactRule rule_of(int joints, double radius) {
  ContactRule rule;
  rule.radii.assign(std::size_t(joints), radius);
  rule.polarity.assign(std::size_t(joints), Polarity::none);
  rule.scale = 1;
  rule.exclusion_begin.assign(std::size_t(joints) + 1, 0);
  return rule;
}

TEST(NewtonGradients, TakeOverWhereAFactorWouldBeTooLarge) {
  const Example s = lattice(1000);
  EXPECT_FALSE(task_of(s.parts, {}, {})->plan.is_bulky);
  const auto bulky = task_of(lattice(8000).parts, {}, {});
  EXPECT_TRUE(bulky->plan.is_bulky);
  // nothing large was made
  EXPECT_TRUE(bulky->plan.row.empty());
  EXPECT_TRUE(bulky->plan.target.empty());
}

TEST(NewtonGradients, LatticesAreResolvedByAllInstructions) {
  const Example s = lattice(216);
  Random random = dice(11);
  Positions start = s.positions;
  perturb(start, 0.2, random);
  for_each_vector_target([&] {
    Positions x = start;
    EXPECT_TRUE(resolve(s.parts, x, {.tolerance = 1e-6}).converged);
    EXPECT_LE(worst_of(s.parts, x), 1e-6);
  });
}

TEST(NewtonGradients, LatticesAreResolvedToEveryTolerance) {
  const Example s = lattice(1000);
  Random random = dice(1);
  for (const double tolerance : {1e-2, 1e-3, 1e-6, 1e-9}) {
    Positions x = s.positions;
    perturb(x, 0.1, random);
    const ResolveReport report = resolve(s.parts, x, {.tolerance = tolerance});
    EXPECT_TRUE(report.converged) << tolerance << " " << report.worst;
    EXPECT_EQ(report.reason, StopReason::within_tolerance);
    EXPECT_LE(worst_of(s.parts, x), tolerance);
    EXPECT_NEAR(report.residual, worst_of(s.parts, x), 1e-12);
    EXPECT_LE(report.iterations, 40);
    // a step's rounds visit the bars too
    EXPECT_GT(report.bar_visits, 3 * report.iterations * std::int64_t(s.parts.bars.size()));
  }
}

TEST(NewtonGradients, ShapesAreThoseThatTheFactorFinds) {
  const Example s = coil(60);
  Random random = dice(2);
  for (const bool weighted : {false, true}) {
    Positions start = s.positions;
    perturb(start, 0.01, random);
    const ResolverSettings settings = {.tolerance = 1e-9, .mass_weights = weighted};
    Positions x = start, y = start;
    EXPECT_TRUE(resolve(s.parts, x, settings).converged);
    const auto factored = task_of(s.parts, settings, {});
    EXPECT_FALSE(factored->plan.is_bulky);
    EXPECT_TRUE(make_newton_resolver(factored)->resolve(y, {}).converged);
    EXPECT_LE(worst_of(s.parts, x), 1e-9);
    for (std::size_t p = 0; p < x.size(); ++p)
      for (std::size_t q = p + 1; q < x.size(); ++q)
        EXPECT_NEAR((x[q] - x[p]).norm(), (y[q] - y[p]).norm(), 1e-6);
  }
}

TEST(NewtonGradients, HeavyJointsMoveLessWhereMassesWeighAsByTheFactor) {
  Example s = lattice(125);
  for (std::size_t j = 0; j < 125; ++j) s.parts.masses[j] = j % 5 == 0 ? 50 : 1;
  Random random = dice(3);
  Positions start = s.positions;
  perturb(start, 0.1, random);
  double heavy[2] = {0, 0};
  for (const bool weighted : {false, true}) {
    double by_factor = 0;
    for (const double most : {-1.0, infinity}) {
      Positions x = start;
      const auto task = task_of(s.parts, {.mass_weights = weighted}, most);
      EXPECT_TRUE(make_newton_resolver(task)->resolve(x, {}).converged);
      double& sum = task->plan.is_bulky ? heavy[weighted] : by_factor;
      for (std::size_t j = 0; j < 125; j += 5) sum += (x[j] - start[j]).squaredNorm();
    }
    EXPECT_NEAR(heavy[weighted], by_factor, 0.1 * by_factor);
  }
  EXPECT_LT(heavy[1], 0.7 * heavy[0]);
}

TEST(NewtonGradients, ContactsOfTheRuleHoldAcrossAPeriodicBox) {
  const Box box{Vec3(2.5, 0, 0), Vec3(0, 2.5, 0), Vec3(0, 0, 2.5)};
  FrameworkParts parts;
  parts.masses.assign(60, 1);
  parts.contact_rule = rule_of(60, 0.25);
  Random random = dice(4);
  Positions x = random_points(60, 2.5, random);
  EXPECT_GT(worst_violation(Framework(parts), x, &box).relative, 0.3);
  const ResolveReport report = resolve(parts, x, {.tolerance = 1e-6}, &box);
  EXPECT_TRUE(report.converged) << report.worst;
  EXPECT_LE(worst_violation(Framework(parts), x, &box).relative, 1e-6);
}

TEST(NewtonGradients, FixedJointsStayAndTheOthersAreResolved) {
  Example s = lattice(216);
  s.parts.fixed.assign(216, 0);
  for (const std::size_t j : {0U, 77U, 215U}) s.parts.fixed[j] = 1;
  Random random = dice(5);
  Positions x = s.positions;
  perturb(x, 0.1, random);
  const Positions start = x;
  const ResolveReport report = resolve(s.parts, x, {.tolerance = 1e-6});
  EXPECT_TRUE(report.converged) << report.worst;
  EXPECT_LE(worst_of(s.parts, x), 1e-6);
  for (const std::size_t j : {0U, 77U, 215U}) EXPECT_EQ(x[j], start[j]);
}

TEST(NewtonGradients, AbsoluteTolerancesAndSinglePrecisionAreKept) {
  const Example s = lattice(216);
  Random random = dice(6);
  for (const Precision precision : {Precision::double_, Precision::single})
    for (const double nanometers : {1e-2, 1e-8}) {
      Positions x = s.positions;
      perturb(x, 0.1, random);
      const Tolerance tolerance = Tolerance::nanometers(nanometers);
      const ResolveReport report =
          resolve(s.parts, x, {.tolerance = tolerance, .precision = precision});
      EXPECT_TRUE(report.converged) << report.worst;
      const Violation worst = worst_violation(Framework(s.parts), x, nullptr, tolerance);
      EXPECT_LE(worst.nanometers, nanometers);
      EXPECT_NEAR(report.residual_nm, worst.nanometers, 1e-12);
    }
}

TEST(NewtonGradients, MaximumOfIterationsIsKeptAndNothingBrokenTakesNone) {
  const Example s = lattice(216);
  Positions x = s.positions;
  const ResolveReport unbroken = resolve(s.parts, x, {.tolerance = 1e-6});
  EXPECT_EQ(unbroken.reason, StopReason::nothing_broken);
  EXPECT_EQ(unbroken.iterations, 0);
  EXPECT_EQ(unbroken.bar_visits, 0);
  EXPECT_EQ(x, s.positions);
  Random random = dice(7);
  perturb(x, 0.1, random);
  const Positions start = x;
  for (const long maximum : {1L, 2L, 3L}) {
    x = start;
    const ResolveReport report =
        resolve(s.parts, x, {.tolerance = 1e-12, .max_iterations = maximum});
    EXPECT_EQ(report.reason, StopReason::max_iterations);
    EXPECT_EQ(report.iterations, maximum);
    EXPECT_NE(report.worst, "");
    EXPECT_NEAR(report.residual, worst_of(s.parts, x), 1e-15);
  }
}

TEST(NewtonGradients, TriangleThatCannotCloseIsNamedAndTheRestResolved) {
  Example s = lattice(216);
  const int n = 216;
  s.positions.insert(s.positions.end(), {{90, 0, 0}, {91, 0.1, 0}, {92, 0, 0}});
  s.parts.masses.assign(std::size_t(n) + 3, 1);
  s.parts.fixed.assign(std::size_t(n) + 3, 0);
  s.parts.labels.assign(std::size_t(n) + 3, "");
  for (int j = n; j < n + 3; ++j) s.parts.labels[std::size_t(j)] = "ODD" + std::to_string(j);
  s.parts.bars.insert(s.parts.bars.end(), {{n, n + 1, 1}, {n + 1, n + 2, 1}, {n, n + 2, 4}});
  Random random = dice(8);
  Positions x = s.positions;
  perturb(x, 0.05, random);
  const ResolveReport report = resolve(s.parts, x, {});
  EXPECT_FALSE(report.converged);
  EXPECT_EQ(report.reason, StopReason::stagnated);
  EXPECT_NE(report.worst.find("ODD"), std::string::npos) << report.worst;
  EXPECT_TRUE(finite(x));
  FrameworkParts rest = s.parts;
  rest.bars.resize(rest.bars.size() - 3);
  EXPECT_LE(worst_of(rest, x), 1e-3);
}

TEST(NewtonGradients, JointsAtOnePlaceEndWithAReason) {
  const Positions tetrahedron = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (const Positions& start :
       {Positions(4, Vec3(1, 1, 1)), Positions{{0, 0, 0}, {0, 0, 0}, {1, 0, 0}, {1, 0, 0}},
        Positions{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}})
    for (const double length : {1e-9, 1.0, 1e9}) {
      FrameworkParts parts = parts_of("ab ac ad bc bd cd", tetrahedron);
      for (Bar& bar : parts.bars) bar.length *= length;
      const double cube = length * length * length;
      parts.volumes = {{0, 1, 2, 3, 0.5 * cube, infinity, cube}};
      Positions x = start;
      const ResolveReport report = resolve(parts, x, {});
      EXPECT_EQ(report.converged, worst_of(parts, x) <= 1e-3);
      EXPECT_EQ(report.converged, report.worst.empty());
      EXPECT_TRUE(finite(x));
      EXPECT_LE(report.iterations, 2000);
    }
}

TEST(NewtonGradients, AutoTakesThemForLatticesBelowOnePercent) {
  const Example s = lattice(5000);
  const auto framework = framework_of(s.parts);
  Random random = dice(10);
  for (const double tolerance : {1e-2, 3e-3}) {
    const auto resolver = make_resolver(framework, {.solver = "auto", .tolerance = tolerance});
    EXPECT_EQ(resolver->solver(), tolerance < 1e-2 ? "newton" : "ordered");
    Positions x = s.positions;
    perturb(x, 0.2, random);
    const ResolveReport report = resolver->resolve(x, {});
    EXPECT_TRUE(report.converged) << report.worst;
    EXPECT_LE(worst_of(s.parts, x), tolerance);
    const auto rounds = report.bar_visits > report.iterations * std::int64_t(s.parts.bars.size());
    EXPECT_EQ(rounds, tolerance < 1e-2);
  }
  const auto lanes = make_ensemble_resolver(framework, {.solver = "newton"}, 0);
  EXPECT_EQ(lanes->lanes(), 1);
  EXPECT_EQ(lanes->solver(), "newton");
}

TEST(NewtonGradients, PositionsThatAreNotFiniteAreReportedAndForgotten) {
  const Example s = lattice(64);
  const auto resolver = make_newton_resolver(task_of(s.parts, {}));
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), infinity, 1e160}) {
    Positions x = s.positions;
    x[2][1] = bad;
    EXPECT_EQ(resolver->resolve(x, {}).reason, StopReason::not_finite);
    x = s.positions;
    x[2][1] += 0.5;
    EXPECT_TRUE(resolver->resolve(x, {}).converged);
  }
}

TEST(NewtonGradients, LanesAreSingleResolversInTurn) {
  const Example s = lattice(216);
  const auto task = task_of(s.parts, {.tolerance = 1e-6, .precision = Precision::single});
  Random random = dice(9);
  Positions all;
  for (int k = 0; k < 3; ++k) {
    Positions x = s.positions;
    perturb(x, 0.1 * k, random);
    all.insert(all.end(), x.begin(), x.end());
  }
  const Positions start = all;
  const auto ensemble = make_newton_ensemble(task, 8);
  EXPECT_EQ(ensemble->lanes(), 1);
  const std::vector<ResolveReport> reports = resolve_all(*ensemble, all, 0, nullptr);
  ASSERT_EQ(reports.size(), 3U);
  const auto single = make_newton_resolver(task);
  for (std::size_t k = 0; k < 3; ++k) {
    Positions x(start.begin() + std::ptrdiff_t(216 * k),
                start.begin() + std::ptrdiff_t(216 * (k + 1)));
    const ResolveReport report = single->resolve(x, {});
    EXPECT_TRUE(report.converged);
    EXPECT_EQ(report.iterations, reports[k].iterations);
    EXPECT_EQ(report.bar_visits, reports[k].bar_visits);
    EXPECT_EQ(report.reason, reports[k].reason);
    for (std::size_t j = 0; j < 216; ++j) EXPECT_EQ(x[j], all[216 * k + j]);
  }
}

}  // namespace
}  // namespace ragdoll
