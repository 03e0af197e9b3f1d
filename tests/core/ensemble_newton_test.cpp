// Tests for core/src/ensemble_newton.cpp and newton_engine.cpp: each lane does what the single
// resolver does, bit for bit.

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cmath>    // abs, cos, sin
#include <cstring>  // memcmp
#include <limits>
#include <set>
#include <string>

#include "examples.h"
#include "molecules.h"
#include "ragdoll/build_framework.h"    // build_framework
#include "ragdoll/ensemble_resolver.h"  // make_ensemble_resolver

namespace ragdoll {
namespace {

using namespace examples;
using Example = examples::Structure;

constexpr double infinity = std::numeric_limits<double>::infinity();

Random dice(std::uint64_t seed) {
  return Random(seed, RandomStream::generate, 2);
}

/// Every kind of constraint, of which the positions satisfy all.
Example with_everything(int joints, Random& random) {
  Example s = random_structure(joints, 4, random);
  const auto distance = [&](int p, int q) {
    return (s.positions[std::size_t(p)] - s.positions[std::size_t(q)]).norm();
  };
  s.parts.fixed.assign(std::size_t(joints), 0);
  s.parts.fixed[1] = 1;
  for (int p = 0; p + 5 < joints; p += 6) {
    s.parts.tethers.push_back({p, p + 4, distance(p, p + 4)});
    s.parts.contacts.push_back({p + 1, p + 5, distance(p + 1, p + 5)});
  }
  for (int a = 0; a + 3 < joints; a += 8) {
    const auto at = [&](int k) { return s.positions[std::size_t(a + k)]; };
    const double volume = signed_volume(at(0), at(1), at(2), at(3));
    const bool right = volume > 0;
    s.parts.volumes.push_back({a, a + 1, a + 2, a + 3, right ? 0.7 * volume : -infinity,
                               right ? infinity : 0.7 * volume, std::abs(volume) + 0.01});
  }
  ContactRule& rule = s.parts.contact_rule;
  rule.radii.assign(std::size_t(joints), 0.05);
  rule.polarity.assign(std::size_t(joints), Polarity::none);
  rule.scale = 1;
  rule.exclusion_begin.assign(std::size_t(joints) + 1, 0);
  for (int p = 0; p < joints; ++p)
    for (int q = p + 1; q < joints; ++q)
      if (distance(p, q) < 0.1) rule.close_pairs.push_back({p, q, distance(p, q)});
  return s;
}

/// Conformers of one structure, each broken its own way, some not at all.
Positions broken(const Example& structure, int count, double size, Random& random) {
  Positions x;
  for (int k = 0; k < count; ++k)
    for (const Vec3& point : structure.positions)
      x.push_back(point + (k % 7 == 3 ? 0 : size * (1 + k % 4)) * random_vector(random));
  return x;
}

bool same_bits(const Positions& x, const Positions& y) {
  return x.size() == y.size() && std::memcmp(x.data(), y.data(), x.size() * sizeof(Vec3)) == 0;
}

void expect_same(const ResolveReport& one, const ResolveReport& two) {
  EXPECT_EQ(one.converged, two.converged);
  EXPECT_EQ(one.iterations, two.iterations);
  EXPECT_EQ(one.bar_visits, two.bar_visits);
  EXPECT_EQ(one.residual, two.residual);
  EXPECT_EQ(one.residual_nm, two.residual_nm);
  EXPECT_EQ(one.reason, two.reason);
  EXPECT_EQ(one.worst, two.worst);
}

/// Resolves the conformers one by one and in lanes, and expects the same of both.
/// @return how many were resolved
int expect_lanes_are_single(const FrameworkParts& parts, const Positions& start,
                            ResolverSettings settings, int lanes = 0, const Box* box = nullptr) {
  settings.solver = "newton";
  const auto framework = framework_of(parts);
  const std::size_t joints = parts.masses.size(), count = start.size() / joints;
  Positions one = start, two = start;
  const auto single = make_resolver(framework, settings);
  std::vector<ResolveReport> reports;
  int resolved = 0;
  for (std::size_t k = 0; k < count; ++k) {
    reports.push_back(single->resolve(std::span(one).subspan(k * joints, joints), {.box = box}));
    resolved += reports.back().converged;
    if (!reports.back().converged) continue;
    const Violation worst = worst_violation(*framework, std::span(one).subspan(k * joints, joints),
                                            box, settings.tolerance);
    EXPECT_LE(settings.tolerance.absolute() ? worst.nanometers : worst.relative,
              settings.tolerance.value());
    EXPECT_NEAR(reports.back().residual, worst.relative, 1e-12);
    EXPECT_NEAR(reports.back().residual_nm, worst.nanometers, 1e-12);
  }
  const auto ensemble = make_ensemble_resolver(framework, settings, lanes);
  const std::vector<ResolveReport> in_lanes = resolve_all(*ensemble, two, 0, box);
  EXPECT_EQ(in_lanes.size(), count);
  for (std::size_t k = 0; k < count; ++k) expect_same(reports[k], in_lanes[k]);
  EXPECT_TRUE(same_bits(one, two));
  return resolved;
}

TEST(NewtonLanes, AreTheSingleRunBitForBitWithAllInstructionsAndPrecisions) {
  Random random = dice(1);
  const Example structure = with_everything(40, random);
  const Positions start = broken(structure, 37, 0.02, random);
  std::set<std::string> seen;
  for (std::int64_t left = hwy::SupportedTargets(); left != 0; left &= left - 1) {
    hwy::SetSupportedTargetsForTest(left & -left);
    const auto ensemble =
        make_ensemble_resolver(framework_of(structure.parts), {.solver = "newton"});
    if (seen.insert(ensemble->instructions()).second) {
      for (const Precision precision : {Precision::double_, Precision::single})
        for (const Tolerance tolerance : {Tolerance(1e-3), Tolerance::nanometers(1e-3)})
          EXPECT_GE(expect_lanes_are_single(structure.parts, start,
                                            {.tolerance = tolerance, .precision = precision}),
                    30)
              << *seen.rbegin();
    }
    hwy::SetSupportedTargetsForTest(0);
  }
  EXPECT_GE(seen.size(), 1U);
}

TEST(NewtonLanes, AreTheSingleRunWhateverTheirNumber) {
  Random random = dice(2);
  const Example structure = with_everything(20, random);
  const Positions start = broken(structure, 11, 0.05, random);
  for (const int lanes : {1, 3, 16, 21})
    expect_lanes_are_single(structure.parts, start, {.tolerance = 1e-6}, lanes);
}

TEST(NewtonLanes, AreTheSingleRunForMoleculesAndTheirTraps) {
  Random random = dice(3);
  for (const Molecule& molecule : {methane_like(1, 9, 17, 35), methylacetamide(), heptane()}) {
    const Framework framework = build_framework(molecule);
    const Positions start = broken({framework.parts(), molecule.positions()}, 19, 0.05, random);
    for (const Precision precision : {Precision::double_, Precision::single})
      for (const bool mass_weights : {false, true})
        EXPECT_GE(expect_lanes_are_single(framework.parts(), start,
                                          {.precision = precision, .mass_weights = mass_weights}),
                  15);
  }
}

TEST(NewtonLanes, AreTheSingleRunForFlatGroupsThatOnlyBarsHold) {
  Random random = dice(7);
  // rings of five side by side, each a little out of its plane
  Example rings;
  for (int k = 0; k < 20; ++k) {
    const double angle = 1.2566370614 * k;
    rings.positions.emplace_back(0.13 * std::cos(angle), 0.13 * std::sin(angle) + 0.5 * (k / 5),
                                 k % 5 == 2 ? 0.005 * (k / 5) : 0);
    rings.parts.masses.push_back(12);
    for (int p = k - k % 5; p < k; ++p)
      rings.parts.bars.push_back(
          {p, k, (rings.positions[std::size_t(p)] - rings.positions[std::size_t(k)]).norm()});
  }
  for (const double size : {0.005, 0.05})
    for (const Precision precision : {Precision::double_, Precision::single})
      EXPECT_GE(expect_lanes_are_single(rings.parts, broken(rings, 19, size, random),
                                        {.precision = precision}),
                19);
}

TEST(NewtonLanes, AreTheSingleRunInAPeriodicBoxAndWhereIterationsRunOut) {
  Random random = dice(4);
  Example structure = with_everything(24, random);
  const Box box{Vec3(1.5, 0, 0), Vec3(0, 1.5, 0), Vec3(0, 0, 1.5)};
  const Positions start = broken(structure, 9, 0.02, random);
  for (const long maximum : {1L, 2L, 3L, 50L})
    expect_lanes_are_single(structure.parts, start, {.max_iterations = maximum}, 0, &box);
}

TEST(NewtonLanes, KeepWhatIsNoNumberToThemselves) {
  Random random = dice(5);
  const Example structure = with_everything(16, random);
  Positions start = broken(structure, 9, 0.02, random);
  start[16 * 2 + 3][1] = std::numeric_limits<double>::quiet_NaN();
  start[16 * 5 + 8][0] = 1e200;
  const auto framework = framework_of(structure.parts);
  const auto ensemble = make_ensemble_resolver(framework, {.solver = "newton"});
  Positions x = start;
  const auto reports = resolve_all(*ensemble, x);
  for (std::size_t k = 0; k < reports.size(); ++k) {
    if (k == 2 || k == 5) {
      EXPECT_EQ(reports[k].reason, StopReason::not_finite);
      continue;
    }
    Positions y(start.begin() + std::ptrdiff_t(16 * k),
                start.begin() + std::ptrdiff_t(16 * k + 16));
    expect_same(make_resolver(framework, {.solver = "newton"})->resolve(y, {}), reports[k]);
    EXPECT_EQ(std::memcmp(y.data(), x.data() + 16 * k, 16 * sizeof(Vec3)), 0);
  }
}

TEST(NewtonLanes, LoadedAtAnyTimeEndAsIfAlone) {
  Random random = dice(6);
  const Example structure = with_everything(30, random);
  const Positions start = broken(structure, 24, 0.03, random);
  const auto framework = framework_of(structure.parts);
  const ResolverSettings settings = {.solver = "newton", .tolerance = 1e-7};
  const auto ensemble = make_ensemble_resolver(framework, settings, 4);
  std::vector<int> in_lane(4, -1);
  int next = 0, finished = 0;
  for (int round = 0; finished < 24; ++round) {
    for (int lane = 0; lane < 4; ++lane) {
      int& conformer = in_lane[std::size_t(lane)];
      if (conformer >= 0 && ensemble->done(lane)) {
        Positions x(30), y(start.begin() + 30 * conformer, start.begin() + 30 * conformer + 30);
        const ResolveReport report = ensemble->unload(lane, x);
        expect_same(make_resolver(framework, settings)->resolve(y, {}), report);
        EXPECT_TRUE(same_bits(x, y));
        conformer = -1;
        ++finished;
      }
      // a lane stays empty for a while now and then
      if (conformer < 0 && next < 24 && (round + lane) % 3 != 0) {
        conformer = next++;
        ensemble->load(lane, std::span(start).subspan(std::size_t(30 * conformer), 30), {});
      }
    }
    ensemble->iterate();
  }
}

}  // namespace
}  // namespace ragdoll
