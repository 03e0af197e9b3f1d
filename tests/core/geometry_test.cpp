// Tests for core/src/geometry.cpp.

#include "ragdoll/geometry.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>  // AngleAxisd
#include <cmath>           // sqrt
#include <numbers>         // pi

#include "examples.h"
#include "molecules.h"
#include "ragdoll/build_framework.h"  // build_framework

namespace ragdoll {
namespace {

using namespace examples;

constexpr double degree = std::numbers::pi / 180;

/// A right angle abc of bonds of length 1, an angle bar ac.
FrameworkParts right_angle() {
  FrameworkParts parts = parts_of("ab bc ac", {{1, 0, 0}, {0, 0, 0}, {0, 1, 0}});
  parts.bars[2].kind = BarKind::angle;
  return parts;
}
const Positions start = {{1, 0, 0}, {0, 0, 0}, {0, 1, 0}};

GeometryReport report_of(const FrameworkParts& parts, const Positions& from,
                         const std::vector<Positions>& frames,
                         std::vector<std::array<int, 4>> omegas = {}) {
  GeometryCheck check(framework_of(parts), from, std::move(omegas), 1e-3);
  for (const Positions& frame : frames) check.add(frame);
  return check.report();
}

TEST(GeometryCheck, InputDeviatesByNothing) {
  const Molecule molecule = methylacetamide();
  const auto framework = std::make_shared<const Framework>(build_framework(molecule));
  GeometryCheck check(framework, molecule.positions(), {{3, 0, 2, 4}}, 1e-3);
  check.add(molecule.positions());
  const GeometryReport report = check.report();
  EXPECT_EQ(report.frames, 1);
  EXPECT_EQ(report.bond_rms, 0);
  EXPECT_EQ(report.bond_max, 0);
  EXPECT_EQ(report.bar_max_relative, 0);
  EXPECT_EQ(report.angle_rms_degree, 0);
  EXPECT_EQ(report.omega_max_deviation_degree, 0);
  EXPECT_EQ(report.contact_violations, 0);
  EXPECT_EQ(report.chirality_inverted, 0);
  EXPECT_NEAR(report.rmsd_max, 0, 1e-7);
}

TEST(GeometryCheck, KnownDisplacementGivesKnownDeviations) {
  // c moves out to 1.2: bond bc longer by .2, ac sqrt(2.44), the angle the same
  const GeometryReport report =
      report_of(right_angle(), start, {{{1, 0, 0}, {0, 0, 0}, {0, 1.2, 0}}});
  EXPECT_NEAR(report.bond_max, 0.2, 1e-12);
  EXPECT_NEAR(report.bond_max_relative, 0.2, 1e-12);
  EXPECT_NEAR(report.bond_rms, 0.2 / std::sqrt(2), 1e-12);
  EXPECT_NEAR(report.angle_rms_degree, 0, 1e-9);
  // the angle bar deviates by less than the bond
  EXPECT_LT(std::sqrt(2.44 / 2) - 1, 0.2);
  EXPECT_NEAR(report.bar_max_relative, 0.2, 1e-12);
}

TEST(GeometryCheck, AngleBarsCountAmongBarsButNotAmongBonds) {
  // c turns by 30 degrees: ac becomes 2 sin(60)
  const Positions turned = {
      {1, 0, 0}, {0, 0, 0}, {std::cos(120 * degree), std::sin(120 * degree), 0}};
  const GeometryReport report = report_of(right_angle(), start, {turned});
  EXPECT_NEAR(report.bond_max, 0, 1e-12);
  EXPECT_NEAR(report.bar_max_relative, 2 * std::sin(60 * degree) / std::sqrt(2) - 1, 1e-12);
  EXPECT_NEAR(report.angle_rms_degree, 30, 1e-9);
}

TEST(GeometryCheck, RmsIsOverAllFramesAndMaximaAreKept) {
  const Positions longer = {{1, 0, 0}, {0, 0, 0}, {0, 1.2, 0}};
  const Positions shorter = {{0.9, 0, 0}, {0, 0, 0}, {0, 1, 0}};
  const GeometryReport report = report_of(right_angle(), start, {start, longer, shorter, start});
  EXPECT_EQ(report.frames, 4);
  EXPECT_NEAR(report.bond_rms, std::sqrt((0.04 + 0.01) / 8), 1e-12);
  EXPECT_NEAR(report.bond_max, 0.2, 1e-12);
  EXPECT_NEAR(report.rmsd_last, 0, 1e-7);
  EXPECT_GT(report.rmsd_max, 0.05);
}

TEST(GeometryCheck, BondsAreMeasuredAgainstTheFrameworkAndRmsdAgainstTheInput) {
  // bars of other lengths than the input's
  FrameworkParts parts = right_angle();
  parts.bars[0].length = 1.1;
  const GeometryReport report = report_of(parts, start, {start});
  EXPECT_NEAR(report.bond_max, 0.1, 1e-12);
  EXPECT_NEAR(report.rmsd_max, 0, 1e-7);
}

TEST(GeometryCheck, OmegaDeviationIsTakenTheShortWayRound) {
  // 175 degrees to -175 is a turn by 10
  const Molecule from = methylacetamide(175);
  const auto framework = std::make_shared<const Framework>(build_framework(from));
  GeometryCheck check(framework, from.positions(), {{3, 0, 2, 4}}, 1e-3);
  check.add(methylacetamide(185).positions());
  EXPECT_NEAR(check.report().omega_max_deviation_degree, 10, 1e-9);
  check.add(methylacetamide(163).positions());
  EXPECT_NEAR(check.report().omega_max_deviation_degree, 12, 1e-9);
  check.add(methylacetamide(-5).positions());
  EXPECT_NEAR(check.report().omega_max_deviation_degree, 180, 1e-9);
}

TEST(GeometryCheck, RigidMotionIsNoDeviation) {
  const Molecule molecule = heptane();
  const auto framework = std::make_shared<const Framework>(build_framework(molecule));
  GeometryCheck check(framework, molecule.positions(), {{0, 1, 2, 3}}, 1e-3);
  Positions moved = molecule.positions();
  for (Vec3& point : moved)
    point = Eigen::AngleAxisd(2, Vec3(1, 2, 3).normalized()) * point + Vec3(5, -4, 3);
  check.add(moved);
  const GeometryReport report = check.report();
  EXPECT_NEAR(report.bar_max_relative, 0, 1e-12);
  EXPECT_NEAR(report.angle_rms_degree, 0, 1e-6);
  EXPECT_NEAR(report.omega_max_deviation_degree, 0, 1e-6);
  EXPECT_NEAR(report.rmsd_max, 0, 1e-6);
  EXPECT_EQ(report.chirality_inverted, 0);
  EXPECT_EQ(report.contact_violations, 0);
}

TEST(GeometryCheck, UnitsThatGoOverFromTransToCisAreCounted) {
  const Molecule trans = methylacetamide(180);
  const auto framework = std::make_shared<const Framework>(build_framework(trans));
  GeometryCheck check(framework, trans.positions(), {}, 1e-3);
  check.add(methylacetamide(150).positions());
  EXPECT_EQ(check.report().planar_inverted, 0);
  check.add(methylacetamide(0).positions());
  EXPECT_EQ(check.report().planar_inverted, 1);
  EXPECT_EQ(check.report().chirality_inverted, 0);
}

TEST(GeometryCheck, MirrorImageInvertsEveryCentre) {
  const Molecule molecule = heptane();
  const auto framework = std::make_shared<const Framework>(build_framework(molecule));
  GeometryCheck check(framework, molecule.positions(), {}, 1e-3);
  Positions mirrored = molecule.positions();
  for (Vec3& point : mirrored) point[2] = -point[2];
  check.add(mirrored);
  EXPECT_EQ(framework->chirality_count(), 7);
  EXPECT_EQ(check.report().chirality_inverted, 7);
  check.add(mirrored);
  EXPECT_EQ(check.report().chirality_inverted, 14);
  EXPECT_NEAR(check.report().bar_max_relative, 0, 1e-12);
}

TEST(GeometryCheck, BarsBeyondARelativeOrAnAbsoluteToleranceAreCounted) {
  // a bond of length 1 longer by .02, the bar ac longer by .0141, ab as it was
  const Positions frame = {{1, 0, 0}, {0, 0, 0}, {0, 1.02, 0}};
  const auto violations = [&](const Tolerance& tolerance) {
    GeometryCheck check(framework_of(right_angle()), start, {}, tolerance);
    check.add(frame);
    EXPECT_NEAR(check.report().bar_max, 0.02, 1e-12);
    return check.report().tolerance_violations;
  };
  EXPECT_EQ(violations(0.005), 2);
  EXPECT_EQ(violations(0.015), 1);
  EXPECT_EQ(violations(0.021), 0);
  EXPECT_EQ(violations(Tolerance::nanometers(0.014)), 2);
  EXPECT_EQ(violations(Tolerance::nanometers(0.0145)), 1);
  EXPECT_EQ(violations(Tolerance::nanometers(0.0201)), 0);
}

TEST(GeometryCheck, VolumesBeyondTheToleranceAreCounted) {
  // of a corner of the unit cube, at least 1: it is flattened to 0.9
  FrameworkParts parts = parts_of("ab", {{0, 0, 0}, {1, 0, 0}});
  parts.masses.assign(4, 1);
  parts.fixed.clear();
  parts.volumes.push_back({0, 1, 2, 3, 1, 9, 1, VolumeKind::planarity});
  const Positions from = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (const auto& [tolerance, violations] :
       {std::pair(Tolerance(0.09), 1), std::pair(Tolerance(0.11), 0),
        std::pair(Tolerance::nanometers(0.09), 1), std::pair(Tolerance::nanometers(0.11), 0)}) {
    GeometryCheck check(framework_of(parts), from, {}, tolerance);
    check.add(from);
    EXPECT_EQ(check.report().tolerance_violations, 0);
    check.add(Positions{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0.9}});
    EXPECT_EQ(check.report().tolerance_violations, violations);
  }
}

TEST(GeometryCheck, ContactsCloserThanTheirBoundAreCounted) {
  FrameworkParts parts;
  parts.masses.assign(3, 1);
  parts.contact_rule.radii.assign(3, 0.2);
  parts.contact_rule.polarity.assign(3, Polarity::none);
  parts.contact_rule.scale = 1;
  parts.contact_rule.exclusion_begin.assign(4, 0);
  const Positions from = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  GeometryCheck check(framework_of(parts), from, {}, 1e-3);
  check.add(from);
  EXPECT_EQ(check.report().contact_violations, 0);
  // within the tolerance of 0.0004 nm, then beyond
  check.add(Positions{{0, 0, 0}, {0.3997, 0, 0}, {2, 0, 0}});
  EXPECT_EQ(check.report().contact_violations, 0);
  EXPECT_NEAR(check.report().contact_worst, 0.0003, 1e-12);
  check.add(Positions{{0, 0, 0}, {0.3, 0, 0}, {0.5, 0, 0}});
  EXPECT_EQ(check.report().contact_violations, 2);
  EXPECT_NEAR(check.report().contact_worst, 0.2, 1e-12);
  // and across a face of the box
  const Box box = {{2.1, 0, 0}, {0, 2, 0}, {0, 0, 2}};
  check.add(from, &box);
  EXPECT_EQ(check.report().contact_violations, 3);
}

TEST(GeometryCheck, FrameworkWithoutBarsIsMeasured) {
  FrameworkParts parts;
  parts.masses = {1};
  const GeometryReport report = report_of(parts, {{1, 2, 3}}, {{{3, 2, 1}}});
  EXPECT_EQ(report.bond_rms, 0);
  EXPECT_EQ(report.angle_rms_degree, 0);
  EXPECT_EQ(report.rmsd_max, 0);
  EXPECT_EQ(report_of(parts, {{1, 2, 3}}, {}).frames, 0);
}

TEST(GeometryCheck, WrongSizesAndTorsionsAreRefused) {
  const auto framework = framework_of(right_angle());
  EXPECT_EQ(refusal_of([&] { GeometryCheck(framework, Positions(2), {}, 1e-3); }),
            "the input has 2 positions, the framework 3 joints");
  EXPECT_EQ(refusal_of([&] {
              GeometryCheck(framework, start, {{0, 1, 2, 3}}, 1e-3);
            }),
            "a torsion names joint 3, which does not exist");
  GeometryCheck check(framework, start, {}, 1e-3);
  EXPECT_EQ(refusal_of([&] { check.add(Positions(4)); }), "a frame has 4 positions instead of 3");
  EXPECT_EQ(check.report().frames, 0);
}

}  // namespace
}  // namespace ragdoll
