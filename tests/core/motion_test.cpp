// Tests for core/src/motion*.cpp, symmetry.cpp and hinge_tree.cpp.

#include "ragdoll/motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <numeric>  // iota

#include "examples.h"                 // refusal_of
#include "molecules.h"                // heptane
#include "ragdoll/build_framework.h"  // build_framework
#include "ragdoll/hinge_tree.h"
#include "ragdoll/superposition.h"
#include "ragdoll/symmetry.h"
#include "ragdoll/walkers.h"

namespace ragdoll {
namespace {

using examples::refusal_of;
using Positions = std::vector<Vec3>;

struct Start {
  std::shared_ptr<const Framework> framework;
  Positions positions;
};

Start heptane() {
  const Molecule molecule = examples::heptane();
  return {std::make_shared<const Framework>(build_framework(molecule)), molecule.positions()};
}

/// A bend of the chain: a direction that constraints follow.
std::vector<Vec3> bend(const Positions& x) {
  Vec3 centre = Vec3::Zero();
  for (const Vec3& point : x) centre += point / double(x.size());
  std::vector<Vec3> mode;
  for (const Vec3& point : x) {
    const double along = (point - centre)[0];
    mode.emplace_back(0, along * along, 0);
  }
  return mode;
}

/// Settings of each kind, with what it needs.
MotionSettings motion_for(MotionKind kind, const Start& start) {
  MotionSettings motion;
  motion.kind = kind;
  motion.size = 0.005;
  motion.modes = {bend(start.positions)};
  motion.mode_amplitude = 0.05;
  motion.thermal_step = 0.01;
  if (kind == MotionKind::thermal)
    for (Vec3& part : motion.modes.front()) part *= 0.1;
  motion.pulls = {{{0}, Vec3(0.01, 0.01, 0), false, Vec3::Zero()}};
  return motion;
}

class MotionOfKind : public testing::TestWithParam<MotionKind> {};

WalkSettings settings_for(const MotionSettings& motion) {
  WalkSettings settings;
  settings.resolver.solver = "newton";
  settings.resolver.tolerance = Tolerance::nanometers(1e-4);
  settings.resolver.max_iterations = 50;
  settings.resolver.seed = 7;
  settings.motion = motion;
  settings.walkers = 2;
  settings.frames = 6;
  settings.stride = 2;
  settings.threads = 1;
  return settings;
}

struct Walked {
  WalkReport report;
  std::vector<WalkFrame> frames;
};

Walked walk_of(const Start& start, const WalkSettings& settings) {
  Walked walked;
  walked.report = walk(start.framework, start.positions, settings, nullptr,
                       [&](const WalkFrame& frame) { walked.frames.push_back(frame); });
  return walked;
}

/// Every kind of constraint, measured here and not by the resolver.
void expect_within(const Framework& framework, const Positions& x, double nanometers) {
  const auto distance = [&](int p, int q) {
    return (x[std::size_t(p)] - x[std::size_t(q)]).norm();
  };
  for (const Bar& bar : framework.bars())
    EXPECT_NEAR(distance(bar.p, bar.q), bar.length, nanometers);
  for (const Tether& tether : framework.tethers())
    EXPECT_LE(distance(tether.p, tether.q), tether.length + nanometers);
  for (const Contact& contact : framework.contacts())
    EXPECT_GE(distance(contact.p, contact.q), contact.length - nanometers);
  for (const Volume& v : framework.volumes()) {
    const double volume = signed_volume(x[std::size_t(v.a)], x[std::size_t(v.b)],
                                        x[std::size_t(v.c)], x[std::size_t(v.d)]);
    const double slack = nanometers * std::pow(v.scale, 2.0 / 3);
    EXPECT_GE(volume, v.lower - slack);
    EXPECT_LE(volume, v.upper + slack);
  }
  const ContactRule& rule = framework.contact_rule();
  for (int p = 0; p < framework.joint_count(); ++p)
    for (int q = p + 1; q < framework.joint_count(); ++q)
      if (!rule.empty() && !rule.excluded(p, q)) {
        EXPECT_GE(distance(p, q), rule.bound(p, q) - nanometers);
      }
}

TEST_P(MotionOfKind, FramesKeepEveryConstraintWithinTheTolerance) {
  const Start start = heptane();
  const Walked walked = walk_of(start, settings_for(motion_for(GetParam(), start)));
  ASSERT_EQ(walked.frames.size(), 12u);
  for (const WalkFrame& frame : walked.frames) {
    expect_within(*start.framework, frame.positions, 1.01e-4);
    EXPECT_GT(superposed_rmsd(frame.positions, start.positions), 1e-3);
  }
}

TEST_P(MotionOfKind, MakesTheSameFramesWithTheSameSeed) {
  const Start start = heptane();
  const WalkSettings settings = settings_for(motion_for(GetParam(), start));
  const Walked one = walk_of(start, settings), other = walk_of(start, settings);
  ASSERT_EQ(one.frames.size(), other.frames.size());
  for (std::size_t k = 0; k < one.frames.size(); ++k)
    EXPECT_EQ(one.frames[k].positions, other.frames[k].positions);
}

TEST_P(MotionOfKind, ReplicaIsTheRunWithItsSeed) {
  const Start start = heptane();
  WalkSettings settings = settings_for(motion_for(GetParam(), start));
  const Walked both = walk_of(start, settings);
  settings.walkers = 1;
  ++settings.resolver.seed;
  const Walked second = walk_of(start, settings);
  ASSERT_EQ(both.frames.size(), 2 * second.frames.size());
  for (std::size_t k = 0; k < second.frames.size(); ++k)
    EXPECT_EQ(both.frames[2 * k + 1].positions, second.frames[k].positions);
}

TEST_P(MotionOfKind, GoesOnFromAStateAsIfItHadNotStopped) {
  const Start start = heptane();
  WalkSettings settings = settings_for(motion_for(GetParam(), start));
  const Walked whole = walk_of(start, settings);
  settings.frames = 3;
  const Walked first = walk_of(start, settings);
  for (const WalkerReport& walker : first.report.walkers) settings.states.push_back(walker.state);
  const Walked second = walk_of(start, settings);
  ASSERT_EQ(second.frames.size(), 6u);
  for (std::size_t k = 0; k < 6; ++k) {
    EXPECT_EQ(second.frames[k].positions, whole.frames[6 + k].positions);
    EXPECT_EQ(second.frames[k].steps, whole.frames[6 + k].steps);
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, MotionOfKind,
                         testing::Values(MotionKind::gaussian, MotionKind::ball,
                                         MotionKind::momentum, MotionKind::hinge, MotionKind::modes,
                                         MotionKind::steer, MotionKind::away,
                                         MotionKind::thermal),
                         [](const auto& kind) { return name_of(kind.param); });

TEST(Motion, LeavesFixedJointsWhereTheyAre) {
  Start start = heptane();
  FrameworkParts parts = start.framework->parts();
  parts.fixed[3] = 1;
  start.framework = std::make_shared<const Framework>(std::move(parts));
  for (const std::string& name : motion_names()) {
    const auto motion =
        motion_factory(start.framework, start.positions, motion_for(motion_kind(name), start))(1);
    Positions x = start.positions;
    for (std::uint64_t step = 0; step < 5; ++step) {
      const Positions before = x;
      Random random(1, RandomStream::perturbation, step);
      motion->move(x, random);
      motion->kept(before, x);
    }
    EXPECT_EQ(x[3], start.positions[3]) << name;
    EXPECT_NE(x[4], start.positions[4]) << name;
  }
}

TEST(Momentum, MakesTheLastStepAgainWithoutItsDrift) {
  const Start start = heptane();
  MotionSettings settings = motion_for(MotionKind::momentum, start);
  settings.size = 1e-3;
  settings.persistence = 0.5;
  const auto motion = motion_factory(start.framework, start.positions, settings)(0);
  Positions after = start.positions;
  const RigidMove drift{Eigen::AngleAxisd(0.3, Vec3(1, 2, 3).normalized()).toRotationMatrix(),
                        Vec3(0.1, -0.2, 0.3)};
  for (Vec3& point : after) point = drift(point);
  motion->kept(start.positions, after);
  for (const double part : motion->state()) EXPECT_NEAR(part, 0, 1e-12);

  after = start.positions;
  after[0] += Vec3(0.004, 0, 0);
  motion->kept(start.positions, after);
  Positions moved = after, still = after;
  Random one(3, RandomStream::perturbation, 0), other(3, RandomStream::perturbation, 0);
  motion->move(moved, one);
  perturb(still, start.framework->fixed(), PerturbationKind::gaussian, 1e-3, other);
  // superposition takes a little of the one joint's step
  EXPECT_NEAR((moved[0] - still[0])[0], 0.5 * 0.004, 2e-4);
}

TEST(Modes, TurnBackAtTheirAmplitudeAndGoBothWays) {
  const Start start = heptane();
  WalkSettings settings = settings_for(motion_for(MotionKind::modes, start));
  settings.motion.size = 1e-4;
  settings.walkers = 1;
  settings.stride = 1;
  settings.frames = 120;
  const std::vector<Vec3> mode = bend(start.positions);
  double least = 0, most = 0, farthest = 0, end = 1;
  for (const WalkFrame& frame : walk_of(start, settings).frames) {
    const RigidMove turn = superposition(frame.positions, start.positions);
    double along = 0, squares = 0;
    for (std::size_t j = 0; j < mode.size(); ++j) {
      along += (turn(frame.positions[j]) - start.positions[j]).dot(mode[j]);
      squares += mode[j].squaredNorm();
    }
    along /= std::sqrt(squares * double(mode.size()));
    least = std::min(least, along);
    most = std::max(most, along);
    end = superposed_rmsd(frame.positions, start.positions);
    farthest = std::max(farthest, end);
  }
  EXPECT_LT(least, -0.01);
  EXPECT_GT(most, 0.01);
  EXPECT_LT(farthest, 1.5 * 0.05 + 0.03);
}

/// A mode that neither drifts nor turns the whole.
std::vector<Vec3> breathing(const Positions& x) {
  Vec3 centre = Vec3::Zero();
  for (const Vec3& point : x) centre += point / double(x.size());
  std::vector<Vec3> mode;
  for (const Vec3& point : x) mode.emplace_back(0.1 * (point - centre));
  return mode;
}

TEST(Thermal, SwingsAboutTheStartWithTheDeviationAndTheStepAskedFor) {
  const Start start = heptane();
  MotionSettings settings = motion_for(MotionKind::thermal, start);
  settings.size = 0;
  settings.modes = {breathing(start.positions)};
  double square = 0;
  for (const Vec3& part : settings.modes[0]) square += part.squaredNorm();
  const double deviation = std::sqrt(square / double(start.positions.size()));
  settings.thermal_step = 0.3 * deviation;
  const auto motion = motion_factory(start.framework, start.positions, settings)(3);
  Positions x = start.positions;
  double squares = 0, steps = 0, mean = 0;
  const int count = 2000;
  for (int k = 0; k < count; ++k) {
    const Positions before = x;
    Random random(3, RandomStream::perturbation, std::uint64_t(k));
    motion->move(x, random);
    motion->kept(before, x);
    const double size = (x[0] - x[1]).norm() / (start.positions[0] - start.positions[1]).norm() - 1;
    squares += size * size / 0.01;
    mean += size / 0.1;
    if (k > 0) steps += std::pow(superposed_rmsd(before, x), 2);
  }
  EXPECT_NEAR(squares / count, 1, 0.05);
  EXPECT_NEAR(mean / count, 0, 0.05);
  // frequencies differ by up to a tenth
  EXPECT_NEAR(std::sqrt(steps / (count - 1)) / settings.thermal_step, 1, 0.11);
}

TEST(Thermal, GoesLessFarAfterAStepThatWasTakenBack) {
  const Start start = heptane();
  MotionSettings settings = motion_for(MotionKind::thermal, start);
  settings.size = 0;
  settings.modes = {breathing(start.positions)};
  settings.thermal_step = 1e-4;  // the target hardly moves
  const auto factory = motion_factory(start.framework, start.positions, settings);
  const auto first_step = [&](int taken_back) {
    const auto motion = factory(1);
    for (int k = 0; k < taken_back; ++k) motion->taken_back();
    Positions x = start.positions;
    Random random(1, RandomStream::perturbation, 0);
    motion->move(x, random);
    return superposed_rmsd(x, start.positions);
  };
  const double whole = first_step(0);
  EXPECT_GT(whole, 0);
  EXPECT_NEAR(first_step(1) / whole, 0.5, 0.02);
  EXPECT_NEAR(first_step(2) / whole, 0.25, 0.02);
  EXPECT_GT(first_step(50) / whole, 0.01);
}

TEST(Thermal, RefusesModesThatMoveNothingOrDoNotFit) {
  const Start start = heptane();
  MotionSettings settings = motion_for(MotionKind::thermal, start);
  const auto refusal = [&] {
    return refusal_of([&] { motion_factory(start.framework, start.positions, settings); });
  };
  settings.modes = {std::vector<Vec3>(start.positions.size(), Vec3::Zero())};
  EXPECT_EQ(refusal(), "a thermal mode moves nothing");
  settings.modes = {std::vector<Vec3>(3, Vec3::Ones())};
  EXPECT_NE(refusal().find("mode 1 moves 3 joints"), std::string::npos);
  settings.modes.clear();
  EXPECT_EQ(refusal(), "a thermal motion needs one mode at least");
}

TEST(Steer, PullsAlongAVectorAndTowardsAPoint) {
  const Start start = heptane();
  MotionSettings settings;
  settings.kind = MotionKind::steer;
  settings.size = 0;
  settings.pulls = {{{2, 4}, Vec3(0, 0, 0.01), false, Vec3::Zero()},
                    {{0}, Vec3(0.02, 0, 0), true, start.positions[0] + Vec3(0, 1, 0)}};
  const auto motion = motion_factory(start.framework, start.positions, settings)(0);
  Positions x = start.positions;
  Random random(0, RandomStream::perturbation, 0);
  motion->move(x, random);
  EXPECT_NEAR((x[2] - start.positions[2] - Vec3(0, 0, 0.01)).norm(), 0, 1e-15);
  EXPECT_NEAR((x[4] - start.positions[4] - Vec3(0, 0, 0.01)).norm(), 0, 1e-15);
  EXPECT_NEAR((x[0] - start.positions[0] - Vec3(0, 0.02, 0)).norm(), 0, 1e-15);
  EXPECT_EQ(x[1], start.positions[1]);
}

TEST(Away, LeadsFurtherThanRandomMoves) {
  const Start start = heptane();
  const auto reached = [&](MotionKind kind, AwayFrom from) {
    WalkSettings settings = settings_for(motion_for(kind, start));
    settings.motion.away = from;
    settings.motion.away_step = 0.02;
    settings.walkers = 4;
    settings.frames = 20;
    double sum = 0;
    for (const WalkFrame& frame : walk_of(start, settings).frames)
      sum += superposed_rmsd(frame.positions, start.positions);
    return sum;
  };
  const double random = reached(MotionKind::gaussian, AwayFrom::nearest);
  EXPECT_GT(reached(MotionKind::away, AwayFrom::nearest), 1.3 * random);
  EXPECT_GT(reached(MotionKind::away, AwayFrom::centroid), 1.3 * random);
  EXPECT_GT(reached(MotionKind::away, AwayFrom::density), 1.3 * random);
}

TEST(HingeTree, FindsTheBondsOfAChainThatTurn) {
  const Start start = heptane();
  const HingeTree tree(*start.framework);
  // seven carbons: the four bonds inside, and the two that turn a methyl group with hydrogens
  const int ends = start.framework->joint_count() > 7 ? 6 : 4;
  EXPECT_EQ(int(tree.hinges().size()), ends);
  std::vector<int> joints = tree.joints();
  std::sort(joints.begin(), joints.end());
  std::vector<int> all(joints.size());
  std::iota(all.begin(), all.end(), 0);
  EXPECT_EQ(joints, all);
  for (const Hinge& hinge : tree.hinges()) {
    const auto [first, last] = tree.component(hinge);
    EXPECT_GE(hinge.first, first);
    EXPECT_LE(hinge.last, last);
    const auto begin = tree.joints().begin();
    EXPECT_NE(std::find(begin + hinge.first, begin + hinge.last, hinge.outer), begin + hinge.last);
    EXPECT_EQ(std::find(begin + hinge.first, begin + hinge.last, hinge.inner), begin + hinge.last);
  }
}

TEST(HingeMotion, KeepsBondLengthsOfWhatItTurns) {
  const Start start = heptane();
  MotionSettings settings = motion_for(MotionKind::hinge, start);
  settings.size = 0;
  const auto motion = motion_factory(start.framework, start.positions, settings)(0);
  Positions x = start.positions;
  Random random(0, RandomStream::perturbation, 0);
  motion->move(x, random);
  EXPECT_GT(superposed_rmsd(x, start.positions), 1e-4);
  for (const Bar& bar : start.framework->bars())
    if (bar.kind == BarKind::bond) {
      EXPECT_NEAR((x[std::size_t(bar.p)] - x[std::size_t(bar.q)]).norm(), bar.length, 1e-12);
    }
}

/// Two heptanes, the second one turned and moved.
struct Pair {
  Start start;
  std::vector<std::vector<int>> copies;
};

Pair two_heptanes() {
  const Start one = heptane();
  const int count = one.framework->joint_count();
  FrameworkParts parts = one.framework->parts();
  Pair pair;
  pair.copies.resize(2);
  pair.start.positions = one.positions;
  const RigidMove move{Eigen::AngleAxisd(std::acos(-1.0), Vec3::UnitZ()).toRotationMatrix(),
                       Vec3(0, 0.9, 0)};
  const auto double_up = [&](auto& list, auto shift) {
    const std::size_t size = list.size();
    for (std::size_t k = 0; k < size; ++k) {
      auto copy = list[k];
      shift(copy);
      list.push_back(copy);
    }
  };
  parts.contact_rule = {};
  parts.labels.clear();
  double_up(parts.masses, [](double&) {});
  double_up(parts.fixed, [](std::uint8_t&) {});
  double_up(parts.bars, [&](Bar& bar) { bar.p += count, bar.q += count; });
  double_up(parts.volumes,
            [&](Volume& v) { v.a += count, v.b += count, v.c += count, v.d += count; });
  // a tether from one to the other, in both ways
  parts.tethers.push_back(
      {0, count + 3, (move(one.positions[3]) - one.positions[0]).norm() + 0.02});
  parts.tethers.push_back({count, 3, (move(one.positions[0]) - one.positions[3]).norm() + 0.02});
  for (int j = 0; j < count; ++j) {
    pair.copies[0].push_back(j);
    pair.copies[1].push_back(count + j);
    pair.start.positions.push_back(move(one.positions[std::size_t(j)]));
  }
  pair.start.framework = std::make_shared<const Framework>(std::move(parts));
  return pair;
}

TEST(Symmetry, CopiesMoveAlikeInEveryKindOfMotion) {
  const Pair pair = two_heptanes();
  const auto symmetry = std::make_shared<const Symmetry>(pair.copies, pair.start.positions);
  for (const std::string& name : motion_names()) {
    WalkSettings settings = settings_for(motion_for(motion_kind(name), pair.start));
    settings.symmetry = symmetry;
    settings.frames = 3;
    const Walked walked = walk_of(pair.start, settings);
    ASSERT_EQ(walked.frames.size(), 6u) << name;
    for (const WalkFrame& frame : walked.frames) {
      EXPECT_LT(symmetry->deviation(frame.positions), 1e-12) << name;
      expect_within(*pair.start.framework, frame.positions, 1.01e-4);
      EXPECT_GT(superposed_rmsd(frame.positions, pair.start.positions), 1e-3) << name;
    }
  }
}

TEST(Symmetry, RefusesCopiesThatAreNone) {
  const Positions x(8, Vec3::Zero());
  EXPECT_EQ(refusal_of([&] { Symmetry({{0, 1, 2}}, x); }), "symmetry needs two copies at least");
  EXPECT_EQ(refusal_of([&] {
              Symmetry({{0, 1, 2}, {3, 4}}, x);
            }),
            "copies must have as many joints each, three at least");
  EXPECT_EQ(refusal_of([&] { Symmetry({{0, 1, 2}, {2, 4, 5}}, x); }), "joint 2 is in two copies");
  EXPECT_EQ(refusal_of([&] {
              Symmetry({{0, 1, 2}, {3, 4, 9}}, x);
            }),
            "joint 9 of a copy is no joint");
}

TEST(Motion, RefusesSettingsThatMakeNoSense) {
  const Start start = heptane();
  const auto refusal = [&](MotionKind kind, auto change) {
    MotionSettings settings = motion_for(kind, start);
    change(settings);
    return refusal_of([&] { motion_factory(start.framework, start.positions, settings); });
  };
  EXPECT_EQ(refusal(MotionKind::gaussian, [](MotionSettings& s) { s.size = -1; }),
            "the size of the perturbation must be 0 nm or more");
  EXPECT_EQ(refusal(MotionKind::momentum, [](MotionSettings& s) { s.persistence = 1.5; }),
            "the persistence of the momentum must be from 0 to 1");
  EXPECT_EQ(refusal(MotionKind::modes, [](MotionSettings& s) { s.modes.clear(); }),
            "a motion along modes needs one mode at least");
  EXPECT_EQ(
      refusal(MotionKind::modes, [](MotionSettings& s) { s.modes[0].pop_back(); }).substr(0, 11),
      "mode 1 move");
  EXPECT_EQ(refusal(MotionKind::steer, [](MotionSettings& s) { s.pulls.clear(); }),
            "steering needs a pull");
  EXPECT_EQ(
      refusal(MotionKind::steer, [](MotionSettings& s) { s.pulls[0].joints = {99}; }).substr(0, 8),
      "joint 99");
  EXPECT_EQ(
      refusal_of([] { motion_kind("jump"); }),
      "perturbation 'jump' is not known; choose one of: gaussian, ball, momentum, hinge, modes, "
      "steer, away");
}

TEST(Motion, RefusesAStateOfAnother) {
  const Start start = heptane();
  const auto make = [&](MotionKind kind) {
    return motion_factory(start.framework, start.positions, motion_for(kind, start))(0);
  };
  const std::vector<double> momentum = make(MotionKind::momentum)->state();
  EXPECT_EQ(refusal_of([&] { make(MotionKind::gaussian)->restore(momentum); }),
            "the state is not one of this perturbation: it is too long");
  EXPECT_EQ(refusal_of([&] { make(MotionKind::momentum)->restore({}); }),
            "the state is not one of this perturbation: it is too short");
}

}  // namespace
}  // namespace ragdoll
