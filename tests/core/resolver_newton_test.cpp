// Tests for core/src/resolver_newton.cpp and what it is made of.

#include <gtest/gtest.h>

#include <algorithm>  // all_of
#include <array>
#include <cmath>  // cos, sin, abs, round
#include <limits>
#include <numbers>  // pi
#include <utility>  // pair

#include "examples.h"
#include "molecules.h"
#include "ragdoll/build_framework.h"  // build_framework
#include "ragdoll/generate.h"         // generate_structure
#include "ragdoll/resolver.h"         // make_resolver

namespace ragdoll {
namespace {

using namespace examples;
using Example = examples::Structure;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

Random dice(std::uint64_t seed) {
  return Random(seed, RandomStream::generate, 1);
}

ResolveReport resolve(const FrameworkParts& parts, Positions& x, double tolerance = 1e-3,
                      long max_iterations = 10000, const Box* box = nullptr) {
  const ResolverSettings settings = {
      .solver = "newton", .tolerance = tolerance, .max_iterations = max_iterations};
  return make_resolver(framework_of(parts), settings)->resolve(x, {.box = box});
}

double worst_of(const FrameworkParts& parts, const Positions& x) {
  return worst_violation(Framework(parts), x, nullptr).relative;
}

bool finite(const Positions& x) {
  return std::all_of(x.begin(), x.end(), [](const Vec3& point) { return point.allFinite(); });
}

void perturb(Positions& x, double sigma, Random& random) {
  for (Vec3& point : x)
    for (int i = 0; i < 3; ++i) point[i] += sigma * random.gaussian();
}

/// An unresolved break is reported in full, and nothing is spoilt.
void expect_reason(const ResolveReport& report, const Positions& x, StopReason reason) {
  EXPECT_FALSE(report.converged);
  EXPECT_EQ(report.reason, reason);
  EXPECT_NE(report.worst, "");
  EXPECT_GT(report.residual, 0);
  EXPECT_TRUE(finite(x));
}

/// The heavy atoms of a chain that winds up, with bars for bonds and angles, chirality at every
/// third joint, planar units, and side chains.
Example helix(int joints) {
  Example s;
  for (int k = 0; k < joints / 2; ++k) {
    const double turn = 1.0 * k;
    const Vec3 main(0.16 * std::cos(turn), 0.16 * std::sin(turn), 0.06 * k);
    const Vec3 out(std::cos(turn + 0.3), std::sin(turn + 0.3), 0.5);
    s.positions.push_back(main);
    s.positions.push_back(main + 0.12 * out);
  }
  s.parts.masses.assign(s.positions.size(), 12);
  const auto bar = [&s](int p, int q, BarKind kind) {
    const double length = (s.positions[std::size_t(q)] - s.positions[std::size_t(p)]).norm();
    s.parts.bars.push_back({p, q, length, kind});
  };
  const int n = int(s.positions.size());
  for (int p = 0; p < n; p += 2) {
    bar(p, p + 1, BarKind::bond);
    if (p + 2 < n) {
      bar(p, p + 2, BarKind::bond);
      bar(p + 1, p + 2, BarKind::angle);
      bar(p, p + 3, BarKind::angle);
    }
    if (p + 4 < n) bar(p, p + 4, BarKind::angle);
    if (p >= 2 && p + 2 < n) {
      const std::array<std::size_t, 4> j = {std::size_t(p), std::size_t(p - 2), std::size_t(p + 1),
                                            std::size_t(p + 2)};
      const double volume =
          signed_volume(s.positions[j[0]], s.positions[j[1]], s.positions[j[2]], s.positions[j[3]]);
      s.parts.volumes.push_back({p, p - 2, p + 1, p + 2, volume > 0 ? volume / 2 : -infinity,
                                 volume > 0 ? infinity : volume / 2, std::abs(volume)});
    }
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

const Positions corner = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};  // volume 1

// === Convergence

TEST(Newton, NothingBrokenTakesNoIterationAndMovesNothing) {
  Random random = dice(1);
  const Example structure = random_structure(30, 6, random);
  Positions x = structure.positions;
  const ResolveReport report = resolve(structure.parts, x);
  EXPECT_EQ(report.iterations, 0);
  EXPECT_EQ(report.bar_visits, 0);
  EXPECT_EQ(report.reason, StopReason::nothing_broken);
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(x, structure.positions);
}

TEST(Newton, OneBarIsSharedEvenly) {
  FrameworkParts parts;
  parts.masses = {1, 50};
  parts.bars = {{0, 1, 1}};
  Positions x = {{0, 0, 0}, {3, 0, 0}};
  const ResolveReport report = resolve(parts, x);
  EXPECT_EQ(report.iterations, 1);
  EXPECT_EQ(report.bar_visits, 1);
  EXPECT_EQ(report.reason, StopReason::within_tolerance);
  EXPECT_EQ(x, (Positions{{1, 0, 0}, {2, 0, 0}}));
}

TEST(Newton, EveryClassOfGraphIsResolvedToEveryTolerance) {
  Random random = dice(2);
  for (const double tolerance : {1e-3, 1e-6, 1e-9})
    for (const char* kind : {"tree", "1-cycle", "2-cycle", "n-cycle", "ring-chain", "protein"})
      for (std::uint64_t index = 0; index < 20; ++index) {
        const auto structure = generate_structure(
            {.class_name = kind, .cycles = 0, .joints = 30, .seed = 3, .index = index});
        const FrameworkParts& parts = structure.parts;
        Positions x = structure.positions;
        x[std::size_t(random.below(30))] += 2 * random_vector(random);
        const ResolveReport report = resolve(parts, x, tolerance);
        EXPECT_TRUE(report.converged) << kind << " " << index << ": " << report.worst;
        EXPECT_LE(worst_of(parts, x), tolerance);
        EXPECT_NEAR(report.residual, worst_of(parts, x), 1e-14);
        EXPECT_EQ(report.bar_visits, report.iterations * std::int64_t(parts.bars.size()));
        EXPECT_LE(report.iterations, 60) << kind;
      }
}

TEST(Newton, LongMoleculesTakeFewIterationsWhateverTheirLength) {
  Random random = dice(3);
  for (const int joints : {300, 1000, 3000}) {
    const Example structure = helix(joints);
    Positions x = structure.positions;
    perturb(x, 0.01, random);
    const ResolveReport report = resolve(structure.parts, x, 1e-4);
    EXPECT_TRUE(report.converged) << report.worst;
    EXPECT_LT(report.iterations, 12) << joints;
    EXPECT_LE(worst_of(structure.parts, x), 1e-4);
    EXPECT_EQ(inverted_centres(Framework(structure.parts), x), 0);
  }
}

TEST(Newton, MoleculesAreResolvedWithoutInvertedCentres) {
  Random random = dice(4);
  for (const Molecule& molecule :
       {methane_like(1, 9, 17, 35), ethane(), ammonia(), formamide(), methylacetamide(), benzene(),
        allene(), cyclopentane_ring(), heptane()}) {
    const Framework framework = build_framework(molecule);
    for (int round = 0; round < 20; ++round) {
      Positions x = molecule.positions();
      perturb(x, 0.02, random);
      const ResolveReport report = resolve(framework.parts(), x);
      EXPECT_TRUE(report.converged) << report.worst;
      EXPECT_LE(worst_violation(framework, x, nullptr).relative, 1e-3);
      EXPECT_EQ(inverted_centres(framework, x), 0);
    }
  }
}

TEST(Newton, MirroredTetrahedronIsTurnedInsideOutOrReported) {
  FrameworkParts parts = parts_of("ab ac ad bc bd cd", corner);
  parts.volumes = {{0, 1, 2, 3, 0.5, infinity, 1}};
  Positions x = corner;
  x[3][2] = -1;
  const ResolveReport report = resolve(parts, x);
  EXPECT_EQ(report.converged, worst_of(parts, x) <= 1e-3);
  if (report.converged) {
    EXPECT_EQ(inverted_centres(Framework(parts), x), 0);
  }
}

TEST(Newton, ForcesOfAMillionAreResolvedOrReported) {
  Random random = dice(5);
  int resolved = 0;
  for (int round = 0; round < 30; ++round) {
    const Example structure = random_structure(12, round % 3, random);
    Positions x = structure.positions;
    x[6] += 1e6 * random_vector(random);
    const ResolveReport report = resolve(structure.parts, x);
    EXPECT_EQ(report.converged, worst_of(structure.parts, x) <= 1e-3);
    EXPECT_TRUE(finite(x));
    resolved += report.converged;
  }
  EXPECT_GE(resolved, 25);
}

// === Other constraints

TEST(Newton, TethersContactsAndVolumesHoldTogether) {
  Random random = dice(6);
  for (int round = 0; round < 20; ++round) {
    Example s = random_structure(20, 4, random);
    const auto distance = [&s](std::size_t p, std::size_t q) {
      return (s.positions[p] - s.positions[q]).norm();
    };
    s.parts.tethers = {{0, 5, distance(0, 5)}, {3, 9, 1.1 * distance(3, 9)}};
    s.parts.contacts = {{1, 7, distance(1, 7)}, {2, 11, 0.9 * distance(2, 11)}};
    const double volume =
        signed_volume(s.positions[4], s.positions[6], s.positions[8], s.positions[10]);
    s.parts.volumes = {{4, 6, 8, 10, volume - 0.01, volume + 0.01, 0.1, VolumeKind::planarity}};
    Positions x = s.positions;
    perturb(x, 0.05, random);
    const ResolveReport report = resolve(s.parts, x, 1e-6);
    EXPECT_TRUE(report.converged) << report.worst;
    EXPECT_LE(worst_of(s.parts, x), 1e-6);
  }
}

TEST(Newton, ContactsOfTheRuleHoldAlsoWhereTheyMeetAllAtOnce) {
  Random random = dice(7);
  for (const double edge : {2.0, 3.0}) {
    FrameworkParts parts;
    parts.masses.assign(60, 1);
    parts.contact_rule = rule_of(60, 0.25);
    Positions x = random_points(60, edge, random);
    EXPECT_GT(worst_of(parts, x), 0.3);
    const ResolveReport report = resolve(parts, x, 1e-6);
    EXPECT_TRUE(report.converged) << report.worst;
    EXPECT_LE(worst_of(parts, x), 1e-6);
  }
}

TEST(Newton, ContactsHoldAcrossAPeriodicBox) {
  const Box box{Vec3(2, 0, 0), Vec3(0, 2, 0), Vec3(0, 0, 2)};
  FrameworkParts parts;
  parts.masses.assign(2, 1);
  parts.contact_rule = rule_of(2, 0.25);
  Positions x = {{0.1, 1, 1}, {1.9, 1, 1}};
  EXPECT_TRUE(resolve(parts, x, 1e-6, 100, &box).converged);
  EXPECT_LE(worst_violation(Framework(parts), x, &box).relative, 1e-6);
}

// === Fixed joints

TEST(Newton, FixedJointsNeverMove) {
  Random random = dice(8);
  for (int round = 0; round < 20; ++round) {
    Example s = random_structure(15, 3, random);
    s.parts.fixed.assign(15, 0);
    for (const std::size_t j : {0U, 5U, 9U}) s.parts.fixed[j] = 1;
    s.parts.tethers = {{0, 1, 0.05}, {5, 9, 0.05}};
    s.parts.contact_rule = rule_of(15, 0.05);
    Positions x = s.positions;
    x[3] += random_vector(random);
    resolve(s.parts, x, 1e-3, 100);
    for (const std::size_t j : {0U, 5U, 9U}) EXPECT_EQ(x[j], s.positions[j]);
    EXPECT_TRUE(finite(x));
  }
}

TEST(Newton, BarBetweenFixedJointsIsReportedAndTheOthersAreResolved) {
  FrameworkParts parts;
  parts.masses.assign(3, 1);
  parts.bars = {{0, 1, 1}, {1, 2, 1}};
  parts.fixed = {1, 1, 0};
  Positions x = {{0, 0, 0}, {3, 0, 0}, {6, 0, 0}};
  const ResolveReport report = resolve(parts, x);
  expect_reason(report, x, StopReason::stagnated);
  EXPECT_EQ(report.worst, "bar joint 0 - joint 1 is 3 nm long instead of 1");
  EXPECT_NEAR((x[2] - Vec3(4, 0, 0)).norm(), 0, 1e-2);
  EXPECT_LE(report.iterations, 20);
}

// === What cannot be met

TEST(Newton, TriangleThatCannotCloseIsReported) {
  FrameworkParts parts;
  parts.masses.assign(3, 1);
  parts.bars = {{0, 1, 1}, {1, 2, 1}, {0, 2, 3}};
  Positions x = {{0, 0, 0}, {1, 0.1, 0}, {2, 0, 0}};
  const ResolveReport report = resolve(parts, x);
  expect_reason(report, x, StopReason::stagnated);
  EXPECT_LT(report.iterations, 500);
  EXPECT_EQ(name_of(report.reason), "stagnated");
  // the misfit is shared by the three
  EXPECT_NEAR(report.residual, 1.0 / 3, 0.01);
}

TEST(Newton, FiveJointsAllOneApartAreReported) {
  FrameworkParts parts;
  parts.masses.assign(5, 1);
  for (int p = 0; p < 5; ++p)
    for (int q = p + 1; q < 5; ++q) parts.bars.push_back({p, q, 1});
  Random random = dice(9);
  for (int round = 0; round < 10; ++round) {
    Positions x = random_points(5, 1, random);
    const ResolveReport report = resolve(parts, x);
    expect_reason(report, x, StopReason::stagnated);
    EXPECT_LT(report.iterations, 500);
  }
}

TEST(Newton, LatticesAreResolvedWhateverTheirSize) {
  const auto lattice = [](int joints, int dimensions) {
    StructureRequest request;
    request.class_name = "grid";
    request.joints = joints;
    request.dimensions = dimensions;
    return generate_structure(request);
  };
  for (const auto& [joints, dimensions] : {std::pair(1000, 2), {1000, 3}, {27000, 3}}) {
    const auto s = lattice(joints, dimensions);
    Positions x(s.positions.begin(), s.positions.end());
    Random random = dice(11);
    perturb(x, 0.1, random);
    EXPECT_TRUE(resolve(s.parts, x).converged);
    EXPECT_LE(worst_of(s.parts, x), 1e-3);
  }
}

TEST(Newton, OneImpossibleTriangleDoesNotSpoilTheRest) {
  Example s = helix(100);
  const int n = int(s.positions.size());
  s.positions.insert(s.positions.end(), {{9, 0, 0}, {9.1, 0, 0}, {9.2, 0, 0}});
  s.parts.masses.assign(std::size_t(n) + 3, 1);
  s.parts.bars.insert(s.parts.bars.end(), {{n, n + 1, 0.12}, {n + 1, n + 2, 0.1}, {n, n + 2, 0.4}});
  s.parts.labels.assign(std::size_t(n) + 3, "");
  s.parts.labels[std::size_t(n)] = "ODD";
  Random random = dice(10);
  Positions x = s.positions;
  perturb(x, 0.01, random);
  const ResolveReport report = resolve(s.parts, x);
  expect_reason(report, x, StopReason::stagnated);
  EXPECT_NE(report.worst.find(std::to_string(n + 2)), std::string::npos) << report.worst;
  FrameworkParts rest = s.parts;
  rest.bars.resize(rest.bars.size() - 3);
  EXPECT_LE(worst_of(rest, x), 1e-3);
}

TEST(Newton, JointsAtOnePlaceAreResolvedOrReported) {
  FrameworkParts pair;
  pair.masses.assign(2, 1);
  pair.bars = {{0, 1, 1}};
  Positions two(2, Vec3(1, 2, 3));
  EXPECT_TRUE(resolve(pair, two).converged);
  Random random = dice(11);
  for (int cycles = 0; cycles < 4; ++cycles) {
    const Example s = random_structure(10, cycles, random);
    Positions x(10, Vec3::Zero());
    const ResolveReport report = resolve(s.parts, x);
    EXPECT_EQ(report.converged, worst_of(s.parts, x) <= 1e-3);
    EXPECT_TRUE(finite(x));
  }
}

TEST(Newton, CollinearAndCoplanarCentresLeaveTheirTrap) {
  FrameworkParts parts = parts_of("ab ac ad bc bd cd", corner);
  parts.volumes = {{0, 1, 2, 3, 0.5, infinity, 1}};
  for (const Positions& start : {Positions{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}},
                                 Positions{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}}) {
    Positions x = start;
    const ResolveReport report = resolve(parts, x);
    EXPECT_EQ(report.converged, worst_of(parts, x) <= 1e-3);
    EXPECT_TRUE(report.converged) << report.worst;
  }
  // without bars, nothing turns a line into a volume but a shake
  FrameworkParts bare;
  bare.masses.assign(4, 1);
  bare.volumes = {{0, 1, 2, 3, 0.5, infinity, 1}};
  Positions x = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}};
  const ResolveReport report = resolve(bare, x);
  EXPECT_EQ(report.converged, worst_of(bare, x) <= 1e-3);
  EXPECT_TRUE(finite(x));
}

TEST(Newton, PositionsThatAreNotFiniteAreReportedAndForgotten) {
  Random random = dice(12);
  Example s = random_structure(10, 2, random);
  s.parts.contact_rule = rule_of(10, 1e-6);
  for (const double bad : {nan, infinity, -infinity, 1e160, 1e300, 1e308}) {
    const auto resolver = make_resolver(framework_of(s.parts), {.solver = "newton"});
    Positions x = s.positions;
    x[2][1] = bad;
    const ResolveReport report = resolver->resolve(x, {});
    EXPECT_FALSE(report.converged);
    EXPECT_EQ(report.reason, StopReason::not_finite);
    EXPECT_LE(report.iterations, 1);
    Positions y = s.positions;
    y[2][1] += 0.5;
    EXPECT_TRUE(resolver->resolve(y, {}).converged);
  }
}

TEST(Newton, MaximumOfIterationsIsKept) {
  const Example s = helix(100);
  Random random = dice(13);
  Positions start = s.positions;
  perturb(start, 0.02, random);
  for (const long maximum : {1L, 2L, 3L, 4L}) {
    Positions x = start;
    const ResolveReport report = resolve(s.parts, x, 1e-12, maximum);
    expect_reason(report, x, StopReason::max_iterations);
    EXPECT_EQ(report.iterations, maximum);
    EXPECT_NEAR(report.residual, worst_of(s.parts, x), 1e-15);
  }
}

// === Settings

TEST(Newton, AbsoluteTolerancesHoldForLongAndShortBarsAlike) {
  FrameworkParts parts;
  parts.masses.assign(4, 1);
  parts.bars = {{0, 1, 0.1}, {1, 2, 10}, {2, 3, 1}};
  const Positions start = {{0, 0, 0}, {0.13, 0, 0}, {10.2, 0.3, 0}, {10.2, 1.7, 0.2}};
  for (const Precision precision : {Precision::double_, Precision::single})
    for (const double nanometers : {1e-2, 1e-4, 1e-8}) {
      Positions x = start;
      const Tolerance tolerance = Tolerance::nanometers(nanometers);
      const ResolveReport report =
          make_resolver(framework_of(parts),
                        {.solver = "newton", .tolerance = tolerance, .precision = precision})
              ->resolve(x, {});
      EXPECT_TRUE(report.converged);
      const Violation worst = worst_violation(Framework(parts), x, nullptr, tolerance);
      EXPECT_LE(worst.nanometers, nanometers);
      EXPECT_NEAR(report.residual_nm, worst.nanometers, 1e-12);
    }
}

TEST(Newton, HeavyJointsMoveLessWhereMassesWeigh) {
  FrameworkParts parts;
  parts.masses = {1, 3};
  parts.bars = {{0, 1, 1}};
  Positions x = {{0, 0, 0}, {3, 0, 0}};
  const ResolverSettings settings = {.solver = "newton", .mass_weights = true};
  EXPECT_TRUE(make_resolver(framework_of(parts), settings)->resolve(x, {}).converged);
  EXPECT_NEAR((x[0] - Vec3(1.5, 0, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR((x[1] - Vec3(2.5, 0, 0)).norm(), 0, 1e-12);

  Random random = dice(15);
  Example s = helix(100);
  for (std::size_t j = 0; j < 100; ++j) s.parts.masses[j] = j % 2 == 0 ? 50 : 1;
  double heavy[2] = {0, 0};
  for (int round = 0; round < 5; ++round) {
    Positions start = s.positions;
    perturb(start, 0.01, random);
    for (const bool weighted : {false, true}) {
      Positions y = start;
      const ResolverSettings both = {.solver = "newton", .mass_weights = weighted};
      EXPECT_TRUE(make_resolver(framework_of(s.parts), both)->resolve(y, {}).converged);
      for (std::size_t j = 0; j < 100; j += 2) heavy[weighted] += (y[j] - start[j]).squaredNorm();
    }
  }
  EXPECT_LT(heavy[1], 0.9 * heavy[0]);
}

TEST(Newton, SinglePrecisionMeetsWhatFloatsCannotAndFarFromTheOrigin) {
  Random random = dice(16);
  const Example s = helix(200);
  for (const double tolerance : {1e-2, 1e-4, 1e-6, 1e-10})
    for (const double away : {0.0, 1e4}) {
      Example there = s;
      for (Vec3& point : there.positions) point += away * Vec3(1, -2, 1);
      Positions x = there.positions;
      perturb(x, 0.01, random);
      const ResolverSettings settings = {
          .solver = "newton", .tolerance = tolerance, .precision = Precision::single};
      const ResolveReport report = make_resolver(framework_of(s.parts), settings)->resolve(x, {});
      if (away > 0 && tolerance < 1e-9) {
        EXPECT_EQ(report.converged, worst_of(s.parts, x) <= tolerance);
        continue;
      }
      EXPECT_TRUE(report.converged) << tolerance << " " << report.worst;
      EXPECT_LE(worst_of(s.parts, x), tolerance);
      EXPECT_LE(report.iterations, 80) << tolerance << " " << away;
    }
}

// === Traps

TEST(Newton, MirroredPlanarGroupsAreTurnedBackWhereTheyAre) {
  Random random = dice(17);
  const Molecule amide = methylacetamide();
  const Framework one = build_framework(amide);
  const std::size_t n = amide.positions().size();
  std::int64_t most[2] = {0, 0};
  for (int size = 0; size < 2; ++size) {
    // many molecules, of which a few have their hydrogens on the wrong side
    const int copies = size == 0 ? 8 : 64;
    FrameworkParts parts;
    Positions x;
    for (int copy = 0; copy < copies; ++copy) {
      const int shift = int(n) * copy;
      parts.masses.insert(parts.masses.end(), one.masses().begin(), one.masses().end());
      for (Bar bar : one.bars()) {
        bar.p += shift;
        bar.q += shift;
        parts.bars.push_back(bar);
      }
      for (Volume v : one.volumes()) {
        for (int* joint : {&v.a, &v.b, &v.c, &v.d}) *joint += shift;
        parts.volumes.push_back(v);
      }
      for (const Vec3& point : amide.positions()) x.push_back(point + Vec3(1.5 * copy, 0, 0));
      if (copy % 4 != 1) continue;
      // the methyl hydrogens of C 3 reflected at it
      for (std::size_t h = 6; h < 9; ++h) {
        Vec3& hydrogen = x[std::size_t(shift) + h];
        hydrogen = 2 * x[std::size_t(shift) + 3] - hydrogen;
      }
    }
    perturb(x, 0.003, random);
    const ResolveReport report = resolve(parts, x);
    EXPECT_TRUE(report.converged) << report.worst;
    EXPECT_LE(worst_of(parts, x), 1e-3);
    EXPECT_EQ(inverted_centres(Framework(parts), x), 0);
    most[size] = report.iterations;
  }
  EXPECT_LE(most[1], 3 * most[0] + 20);
}

TEST(Newton, ManyContradictionsEndInStagnation) {
  FrameworkParts parts;
  Positions x;
  for (int k = 0; k < 200; ++k) {
    const int j = 3 * k;
    parts.masses.insert(parts.masses.end(), 3, 1);
    parts.bars.insert(parts.bars.end(), {{j, j + 1, 1}, {j + 1, j + 2, 1}, {j, j + 2, 3}});
    for (int i = 0; i < 3; ++i) x.emplace_back(i, 0.1 * i * i, 10 * k);
  }
  const ResolveReport report = resolve(parts, x);
  expect_reason(report, x, StopReason::stagnated);
  EXPECT_LT(report.iterations, 1000);
}

TEST(Newton, DegenerateFrameworksEndWithAReason) {
  const Positions line = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}};
  for (const Positions& start :
       {line, Positions(4, Vec3(1, 1, 1)), Positions{{0, 0, 0}, {0, 0, 0}, {1, 0, 0}, {1, 0, 0}}})
    for (const Precision precision : {Precision::double_, Precision::single})
      for (const double length : {1e-9, 1.0, 1e9}) {
        FrameworkParts parts = parts_of("ab ac ad bc bd cd", corner);
        for (Bar& bar : parts.bars) bar.length *= length;
        const double cube = length * length * length;
        parts.volumes = {{0, 1, 2, 3, 0.5 * cube, infinity, cube}};
        Positions x = start;
        const ResolverSettings settings = {.solver = "newton", .precision = precision};
        const ResolveReport report = make_resolver(framework_of(parts), settings)->resolve(x, {});
        EXPECT_EQ(report.converged, worst_of(parts, x) <= 1e-3);
        EXPECT_TRUE(finite(x));
        EXPECT_LE(report.iterations, 2000);
      }
}

// === Flat groups

/// Bars between all joints.
FrameworkParts all_bars(const Positions& x) {
  FrameworkParts parts;
  parts.masses.assign(x.size(), 12);
  for (std::size_t p = 0; p < x.size(); ++p)
    for (std::size_t q = p + 1; q < x.size(); ++q)
      parts.bars.push_back({int(p), int(q), (x[q] - x[p]).norm()});
  return parts;
}

/// A ring of five, one corner of which is out of the plane.
Positions ring_of_five(double out) {
  Positions x;
  for (int k = 0; k < 5; ++k) {
    const double angle = 2 * std::numbers::pi * k / 5;
    x.emplace_back(0.13 * std::cos(angle), 0.13 * std::sin(angle), k == 2 ? out : 0);
  }
  return x;
}

TEST(Newton, PlanarMoleculesConvergeByTheSquare) {
  Random random = dice(18);
  for (const Molecule& molecule : {benzene(), methylacetamide(), formamide()}) {
    const Framework framework = build_framework(molecule);
    for (int round = 0; round < 20; ++round) {
      Positions x = molecule.positions();
      perturb(x, 0.01, random);
      const ResolveReport report = resolve(framework.parts(), x, 1e-9);
      EXPECT_TRUE(report.converged) << report.worst;
      EXPECT_LE(report.iterations, 9);
      EXPECT_LE(worst_of(framework.parts(), x), 1e-9);
    }
  }
}

TEST(Newton, FlatGroupsThatOnlyBarsHoldConvergeByTheSquare) {
  Random random = dice(19);
  for (const double out : {0.0, 1e-4, 0.003, 0.01, 0.03}) {
    const FrameworkParts parts = all_bars(ring_of_five(out));
    for (int round = 0; round < 20; ++round) {
      Positions x = ring_of_five(out);
      perturb(x, 0.004, random);
      const ResolveReport report = resolve(parts, x, 1e-8);
      EXPECT_TRUE(report.converged) << report.worst;
      EXPECT_LE(report.iterations, 9) << out;
      EXPECT_LE(worst_of(parts, x), 1e-8);
    }
  }
}

TEST(Newton, FlatGroupsThatOnlyBarsHoldTakeTheNearerOfTheirMirrorImages) {
  Random random = dice(20);
  const FrameworkParts parts = all_bars(ring_of_five(0.03));
  for (const double side : {1.0, -1.0})
    for (int round = 0; round < 10; ++round) {
      Positions x = ring_of_five(side * 0.03);
      perturb(x, 0.002, random);
      EXPECT_TRUE(resolve(parts, x, 1e-6).converged);
      EXPECT_GT(side * signed_volume(x[0], x[1], x[3], x[2]), 0);
    }
}

TEST(Newton, VolumesThatMayBeEitherMirrorImageTakeTheNearer) {
  Random random = dice(21);
  FrameworkParts parts = parts_of("ab ac ad bc bd cd", corner);
  parts.volumes = {{0, 1, 2, 3, -1.5, 1.5, 1}};
  for (const double side : {1.0, -1.0})
    for (int round = 0; round < 10; ++round) {
      Positions x = corner;
      x[3][2] = side;
      perturb(x, 0.1, random);
      EXPECT_TRUE(resolve(parts, x, 1e-6).converged);
      EXPECT_GT(side * signed_volume(x[0], x[1], x[2], x[3]), 0);
    }
}

TEST(Newton, VolumesWhoseBarsCannotAllBeMetStayWithinTheirBounds) {
  Random random = dice(22);
  // the bars leave a volume that is out of bounds, or none at all
  for (const double stretch : {1.0, 0.4}) {
    FrameworkParts parts = parts_of("ab ac ad bc bd cd", corner);
    parts.bars.back().length *= stretch;
    parts.volumes = {{0, 1, 2, 3, 1.2, 2, 1}};
    Positions x = corner;
    perturb(x, 0.05, random);
    expect_reason(resolve(parts, x), x, StopReason::stagnated);
  }
  // lengths rounded, so that the aim is not quite what the bars leave
  const Molecule molecule = benzene();
  FrameworkParts parts = build_framework(molecule).parts();
  for (Bar& bar : parts.bars) bar.length = std::round(bar.length * 1e4) / 1e4;
  for (int round = 0; round < 10; ++round) {
    Positions x = molecule.positions();
    perturb(x, 0.01, random);
    const ResolveReport report = resolve(parts, x, 2e-3);
    EXPECT_TRUE(report.converged) << report.worst;
    EXPECT_LE(report.iterations, 40);
  }
}

// === Repeatable

TEST(Newton, ResultDependsOnThePositionsAlone) {
  Random random = dice(14);
  Example s = helix(200);
  s.parts.contact_rule = rule_of(200, 0.05);
  const ResolverSettings settings = {.solver = "newton", .tolerance = 1e-4};
  const auto used = make_resolver(framework_of(s.parts), settings);
  for (int round = 0; round < 10; ++round) {
    Positions x = s.positions;
    perturb(x, 0.005 * (1 + round % 4), random);
    Positions y = x;
    const ResolveReport one = used->resolve(x, {});
    const ResolveReport two = make_resolver(framework_of(s.parts), settings)->resolve(y, {});
    EXPECT_EQ(x, y);
    EXPECT_EQ(one.iterations, two.iterations);
    EXPECT_EQ(one.residual, two.residual);
    EXPECT_EQ(one.reason, two.reason);
  }
}

}  // namespace
}  // namespace ragdoll
