// Tests for core/src/approach.cpp, common_framework.cpp and backbone_guide.cpp.

#include "ragdoll/approach.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numeric>  // iota

#include "examples.h"   // refusal_of
#include "molecules.h"  // heptane
#include "peptides.h"   // alanines
#include "ragdoll/backbone_guide.h"
#include "ragdoll/build_framework.h"
#include "ragdoll/common_framework.h"
#include "ragdoll/superposition.h"
#include "ragdoll/walkers.h"

namespace ragdoll {
namespace {

using examples::refusal_of;
using Positions = std::vector<Vec3>;

struct Ends {
  std::shared_ptr<const Framework> framework;
  Positions start, end;
};

/// Heptane, and where a walk took it.
Ends heptanes() {
  const Molecule molecule = examples::heptane();
  Ends ends{std::make_shared<const Framework>(build_framework(molecule)), molecule.positions(), {}};
  WalkSettings walking;
  walking.resolver.solver = "newton";
  walking.resolver.tolerance = Tolerance::nanometers(1e-4);
  walking.motion.kind = MotionKind::momentum;
  walking.motion.size = 0.01;
  walking.frames = 1;
  walking.stride = 30;
  walk(ends.framework, ends.start, walking, nullptr,
       [&](const WalkFrame& frame) { ends.end = frame.positions; });
  return ends;
}

ApproachSettings settings_for(const Ends& ends) {
  ApproachSettings settings;
  settings.resolver.solver = "newton";
  settings.resolver.tolerance = Tolerance::nanometers(1e-4);
  settings.resolver.max_iterations = 60;
  settings.joints.resize(ends.start.size());
  std::iota(settings.joints.begin(), settings.joints.end(), 0);
  settings.target = ends.end;
  settings.stages = {std::vector<double>(ends.start.size(), 1)};
  settings.sites = settings.joints;
  settings.motion.size = 0.003;
  return settings;
}

struct Path {
  ApproachReport report;
  std::vector<ApproachFrame> frames;
};

Path path_of(const Ends& ends, const ApproachSettings& settings) {
  Path path;
  path.report = approach(ends.framework, ends.start, settings, nullptr,
                         [&](const ApproachFrame& frame) { path.frames.push_back(frame); });
  return path;
}

double widest(const Positions& a, const Positions& b) {
  double most = 0;
  for (std::size_t j = 0; j < a.size(); ++j) most = std::max(most, (a[j] - b[j]).norm());
  return most;
}

TEST(Approach, ArrivesInSmallStepsThatKeepEveryConstraint) {
  const Ends ends = heptanes();
  ASSERT_GT(superposed_rmsd(ends.start, ends.end), 0.05);
  for (const bool wander : {false, true}) {
    ApproachSettings settings = settings_for(ends);
    settings.wander = wander;
    const Path path = path_of(ends, settings);
    EXPECT_TRUE(path.report.arrived);
    EXPECT_LT(path.report.rmsd_end, 0.01);
    EXPECT_NEAR(path.report.rmsd_start, superposed_rmsd(ends.start, ends.end), 1e-12);
    ASSERT_GT(path.frames.size(), 2u);
    EXPECT_EQ(path.report.frames, std::int64_t(path.frames.size()));
    Positions before = ends.start;
    double rmsd = path.report.rmsd_start;
    for (const ApproachFrame& frame : path.frames) {
      EXPECT_LT(frame.rmsd, rmsd);
      EXPECT_NEAR(frame.rmsd, superposed_rmsd(frame.positions, ends.end), 1e-9);
      EXPECT_LE(widest(frame.positions, before), settings.widest);
      EXPECT_LE(
          worst_violation(*ends.framework, frame.positions, nullptr, settings.resolver.tolerance)
              .nanometers,
          1.01e-4);
      EXPECT_EQ(inverted_centres(*ends.framework, frame.positions), 0);
      before = frame.positions;
      rmsd = frame.rmsd;
    }
  }
}

TEST(Approach, GoesTheSameWayWithTheSameSeedAndAnotherWithAnother) {
  const Ends ends = heptanes();
  ApproachSettings settings = settings_for(ends);
  settings.wander = true;
  const Path one = path_of(ends, settings), again = path_of(ends, settings);
  ASSERT_EQ(one.frames.size(), again.frames.size());
  for (std::size_t k = 0; k < one.frames.size(); ++k)
    EXPECT_EQ(one.frames[k].positions, again.frames[k].positions);
  ++settings.resolver.seed;
  EXPECT_NE(path_of(ends, settings).frames[0].positions, one.frames[0].positions);
}

TEST(Approach, JointsWithoutATargetGoAlong) {
  const Ends ends = heptanes();
  ApproachSettings settings = settings_for(ends);
  // every second joint
  settings.joints.clear();
  settings.target.clear();
  for (int joint = 0; joint < int(ends.start.size()); joint += 2) {
    settings.joints.push_back(joint);
    settings.target.push_back(ends.end[std::size_t(joint)]);
  }
  settings.stages = {std::vector<double>(settings.joints.size(), 1)};
  settings.sites.resize(settings.joints.size());
  std::iota(settings.sites.begin(), settings.sites.end(), 0);
  const Path path = path_of(ends, settings);
  EXPECT_TRUE(path.report.arrived);
}

/// Heptane with three fixed carbons and what hangs on them; the end is where the rest walked.
Ends pinned_heptanes() {
  const Molecule molecule = examples::heptane();
  FrameworkParts parts = build_framework(molecule).parts();
  for (int atom = 0; atom < 3; ++atom) parts.fixed[std::size_t(atom)] = 1;
  Ends ends{std::make_shared<const Framework>(std::move(parts)), molecule.positions(), {}};
  WalkSettings walking;
  walking.resolver.solver = "newton";
  walking.resolver.tolerance = Tolerance::nanometers(1e-4);
  walking.motion.kind = MotionKind::momentum;
  walking.motion.size = 0.01;
  walking.frames = 1;
  walking.stride = 30;
  walk(ends.framework, ends.start, walking, nullptr,
       [&](const WalkFrame& frame) { ends.end = frame.positions; });
  return ends;
}

TEST(Approach, LeavesFixedJointsAndSuperposesNothingThen) {
  const Ends ends = pinned_heptanes();
  const auto plain = [&](const Positions& x) {
    double squares = 0;
    for (std::size_t j = 0; j < x.size(); ++j) squares += (x[j] - ends.end[j]).squaredNorm();
    return std::sqrt(squares / double(x.size()));
  };
  ASSERT_GT(plain(ends.start), 0.05);
  const Path path = path_of(ends, settings_for(ends));
  EXPECT_TRUE(path.report.arrived);
  EXPECT_NEAR(path.report.rmsd_start, plain(ends.start), 1e-12);
  ASSERT_FALSE(path.frames.empty());
  for (const ApproachFrame& frame : path.frames) {
    for (std::size_t j = 0; j < 3; ++j) EXPECT_EQ(frame.positions[j], ends.start[j]);
    EXPECT_NEAR(frame.rmsd, plain(frame.positions), 1e-9);
  }
}

TEST(Approach, SaysThatItDidNotArriveWhereAConstraintForbidsIt) {
  Ends ends = heptanes();
  // the end is twice as large
  for (Vec3& point : ends.end) point *= 2;
  ApproachSettings settings = settings_for(ends);
  settings.retries = 2;
  const Path path = path_of(ends, settings);
  EXPECT_FALSE(path.report.arrived);
  EXPECT_GT(path.report.rmsd_end, settings.arrived);
  for (const ApproachFrame& frame : path.frames)
    EXPECT_LE(
        worst_violation(*ends.framework, frame.positions, nullptr, settings.resolver.tolerance)
            .nanometers,
        1.01e-4);
}

TEST(Approach, StopsWhereItIsAsked) {
  const Ends ends = heptanes();
  int asked = 0;
  const ApproachReport report = approach(
      ends.framework, ends.start, settings_for(ends), nullptr, [](const ApproachFrame&) {},
      [&] { return ++asked < 3; });
  EXPECT_TRUE(report.interrupted);
  EXPECT_LE(report.steps, 3);
}

TEST(Approach, RefusesSettingsThatMakeNoSense) {
  const Ends ends = heptanes();
  const auto refusal = [&](auto change) {
    ApproachSettings settings = settings_for(ends);
    change(settings);
    return refusal_of([&] { path_of(ends, settings); });
  };
  EXPECT_EQ(refusal([](ApproachSettings& s) { s.joints.resize(2); }),
            "a target needs three joints at least");
  EXPECT_EQ(refusal([](ApproachSettings& s) { s.stages.clear(); }), "an approach needs a stage");
  EXPECT_EQ(refusal([](ApproachSettings& s) { s.stages[0].pop_back(); }),
            "a stage needs one weight for each target");
  EXPECT_EQ(refusal([](ApproachSettings& s) { s.sites.clear(); }), "an approach needs sites");
  EXPECT_EQ(refusal([](ApproachSettings& s) { s.sites[0] = 99; }),
            "site 99 is none of the targets");
  EXPECT_EQ(refusal([](ApproachSettings& s) { s.joints[0] = -1; }),
            "joint -1 of the target is no joint");
}

/// Four joints in a row, 0.1 nm apart.
Framework row(std::vector<Tether> tethers, std::vector<Contact> contacts) {
  FrameworkParts parts;
  parts.masses.assign(4, 12);
  parts.bars = {{0, 1, 0.1}, {1, 2, 0.1}, {2, 3, 0.1}};
  parts.tethers = std::move(tethers);
  parts.contacts = std::move(contacts);
  return Framework(std::move(parts));
}

TEST(CommonFramework, KeepsWidensAndDropsBounds) {
  const Positions start = {{0, 0, 0}, {0.1, 0, 0}, {0.1, 0.1, 0}, {0, 0.1, 0}};
  // stretched: 0 and 3 are 0.3 apart, 0 and 2 are 0.2
  const Positions other = {{0, 0, 0}, {0.1, 0, 0}, {0.2, 0, 0}, {0.3, 0, 0}};
  const std::vector<int> all = {0, 1, 2, 3};
  const Framework framework =
      row({{0, 3, 0.15}, {0, 2, 0.19}, {1, 3, 0.5}}, {{0, 3, 0.09}, {1, 2, 0.11}});
  CommonBounds bounds;
  const Framework common = common_framework(framework, start, all, other, 0.03, &bounds);
  EXPECT_EQ(bounds.dropped, 1);
  EXPECT_EQ(bounds.widened, 2);
  EXPECT_EQ(bounds.kept, 2);
  ASSERT_EQ(common.tethers().size(), 2u);
  EXPECT_NEAR(common.tethers()[0].length, 0.2, 0.003);
  EXPECT_EQ(common.tethers()[1].length, 0.5);
  ASSERT_EQ(common.contacts().size(), 2u);
  EXPECT_LE(common.contacts()[1].length, 0.1);
  EXPECT_LE(worst_violation(common, other, nullptr).relative, 1e-12);
  EXPECT_EQ(common.bars().size(), framework.bars().size());
}

TEST(CommonFramework, GuessesDistancesOfJointsThatAreNotKnown) {
  const Positions start = {{0, 0, 0}, {0.1, 0, 0}, {0.1, 0.1, 0}, {0, 0.1, 0}};
  // 1 and 2 are known, and come apart by 0.2
  const Positions other = {{0.1, 0, 0}, {0.1, 0.3, 0}};
  const Framework framework = row({{0, 3, 0.15}}, {});
  EXPECT_EQ(common_framework(framework, start, std::vector<int>{1, 2}, other).tethers().size(), 0u);
  const Positions same = {{0.1, 0, 0}, {0.1, 0.1, 0}};
  EXPECT_EQ(common_framework(framework, start, std::vector<int>{1, 2}, same).tethers().size(), 1u);
}

TEST(BackboneGuide, TurnsPeptidePlanesToWhereTheMapAllowsWithCaWhereTheyAre) {
  // core: phi below -40, psi above 100; nothing else is allowed
  constexpr int side = 36;
  std::vector<double> density(side * side, 0);
  for (int psi = 0; psi < side; ++psi)
    for (int phi = 0; phi < side; ++phi)
      if (-180 + 10 * phi < -40 && -180 + 10 * phi > -150 && -180 + 10 * psi > 100)
        density[std::size_t(psi * side + phi)] = 20;
  const RamachandranDensity map(density, 17, 1);
  for (const examples::PhiPsi from : {examples::PhiPsi{-20, 130}, examples::PhiPsi{-80, 70}}) {
    const Molecule molecule = examples::alanines({{-80, 130}, from, {-80, 130}});
    // alanine k begins at 3 + 5 k: N, CA, C, O, CB
    const auto n = [](int k) { return 3 + 5 * k; };
    const GuidedResidue residue{n(0) + 2, n(1), n(1) + 1, n(1) + 2, n(2), 0, 1, true};
    const std::vector<PeptidePlane> planes = {{n(0) + 1, n(1) + 1, {n(0) + 2, n(0) + 3, n(1)}},
                                              {n(1) + 1, n(2) + 1, {n(1) + 2, n(1) + 3, n(2)}}};
    const BackboneGuide guide(map, {residue}, planes, 0.05);
    Positions x = molecule.positions();
    for (int step = 0; step < 30; ++step) guide.move(x);
    const examples::PhiPsi to = examples::torsions_of(x, 1);
    EXPECT_EQ(map.region(to.phi, to.psi), RamachandranRegion::core)
        << from.phi << " " << from.psi << " went to " << to.phi << " " << to.psi;
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(x[std::size_t(n(k) + 1)], molecule.positions()[std::size_t(n(k) + 1)]);
  }
}

TEST(BackboneGuide, LeavesResiduesThatArePlausible) {
  const RamachandranDensity map(std::vector<double>(36 * 36, 20), 17, 1);
  const Molecule molecule = examples::alanines({{-80, 130}, {60, 60}, {-80, 130}});
  const BackboneGuide guide(map, {{5, 8, 9, 10, 13, 0, 1, true}},
                            {{4, 9, {5, 6, 8}}, {9, 14, {10, 11, 13}}}, 0.05);
  Positions x = molecule.positions();
  guide.move(x);
  EXPECT_EQ(x, molecule.positions());
}

}  // namespace
}  // namespace ragdoll
