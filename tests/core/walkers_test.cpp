// Tests for core/src/walkers.cpp and walk_board.cpp.

#include "ragdoll/walkers.h"

#include <gtest/gtest.h>

#include <map>
#include <stdexcept>

#include "examples.h"                 // refusal_of
#include "molecules.h"                // heptane
#include "ragdoll/build_framework.h"  // build_framework

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

/// Settings in which about one step in four is rejected, so that walkers run apart.
WalkSettings settings_for(const std::string& solver) {
  WalkSettings settings;
  settings.resolver.solver = solver;
  settings.resolver.tolerance = 0.01;
  settings.resolver.max_iterations = solver == "newton" ? 5 : 20;
  settings.resolver.seed = 40;
  settings.motion.size = 0.02;
  settings.walkers = 7;
  settings.frames = 4;
  settings.stride = 3;
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

/// A walker as the method tells it: perturb, resolve, keep or take back.
Walked walk_alone(const Start& start, const WalkSettings& settings, int number) {
  ResolverSettings own = settings.resolver;
  own.seed += std::uint64_t(number);
  const auto resolver = make_resolver(start.framework, own);
  Walked walked;
  WalkerReport& done = walked.report.walkers.emplace_back();
  done.seed = own.seed;
  Positions good = start.positions;
  int accepted = 0;
  while (done.frames < settings.frames &&
         done.steps < settings.attempts * settings.frames * settings.stride) {
    Positions x = good;
    Random random(own.seed, RandomStream::perturbation, std::uint64_t(done.steps));
    perturb(x, start.framework->fixed(), perturbation_kind(name_of(settings.motion.kind)),
            settings.motion.size, random);
    const ResolveReport report = resolver->resolve(x, {.step = std::uint64_t(done.steps)});
    ++done.steps;
    done.iterations.push_back(report.iterations);
    if (!report.converged || inverted_centres(*start.framework, x) > 0) {
      ++done.rejected_steps;
      continue;
    }
    good = x;
    if (++accepted % settings.stride == 0)
      walked.frames.push_back({number, done.frames++, done.steps, report, x});
  }
  return walked;
}

void expect_same(const WalkFrame& frame, const WalkFrame& other) {
  EXPECT_EQ(frame.walker, other.walker);
  EXPECT_EQ(frame.number, other.number);
  EXPECT_EQ(frame.steps, other.steps);
  EXPECT_EQ(frame.positions, other.positions);
  EXPECT_EQ(frame.report.iterations, other.report.iterations);
  EXPECT_EQ(frame.report.bar_visits, other.report.bar_visits);
  EXPECT_EQ(frame.report.residual, other.report.residual);
  EXPECT_EQ(frame.report.converged, other.report.converged);
}

void expect_walkers_alone(const Start& start, const WalkSettings& settings) {
  const Walked together = walk_of(start, settings);
  std::map<int, std::vector<WalkFrame>> frames;
  for (const WalkFrame& frame : together.frames) frames[frame.walker].push_back(frame);
  ASSERT_EQ(int(together.report.walkers.size()), settings.walkers);
  for (int k = 0; k < settings.walkers; ++k) {
    const Walked alone = walk_alone(start, settings, k);
    const WalkerReport &report = together.report.walkers[std::size_t(k)],
                       &expected = alone.report.walkers[0];
    EXPECT_EQ(report.seed, expected.seed);
    EXPECT_EQ(report.frames, expected.frames);
    EXPECT_EQ(report.steps, expected.steps);
    EXPECT_EQ(report.rejected_steps, expected.rejected_steps);
    EXPECT_EQ(report.iterations, expected.iterations);
    ASSERT_EQ(frames[k].size(), alone.frames.size());
    for (std::size_t f = 0; f < alone.frames.size(); ++f)
      expect_same(frames[k][f], alone.frames[f]);
  }
}

class WalkersOfSolver : public testing::TestWithParam<const char*> {};

TEST_P(WalkersOfSolver, DoBitForBitWhatEachDoesAlone) {
  const Start start = heptane();
  WalkSettings settings = settings_for(GetParam());
  for (const Precision precision : {Precision::double_, Precision::single}) {
    settings.resolver.precision = precision;
    expect_walkers_alone(start, settings);
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, WalkersOfSolver, testing::Values("ordered", "newton", "auto"));

TEST(Walkers, HaveRandomOrdersOfTheirOwn) {
  WalkSettings settings = settings_for("ordered");
  settings.resolver.max_iterations = 40;
  for (const OrderKind order : {OrderKind::random, OrderKind::bfs_random}) {
    settings.resolver.order = order;
    expect_walkers_alone(heptane(), settings);
  }
}

TEST(Walkers, MoveInABallIfAsked) {
  WalkSettings settings = settings_for("ordered");
  settings.motion.kind = MotionKind::ball;
  expect_walkers_alone(heptane(), settings);
}

TEST(Walkers, GiveTheirFramesRoundByRoundWhateverTheThreadsAndLanes) {
  const Start start = heptane();
  WalkSettings settings = settings_for("ordered");
  const std::vector<WalkFrame> expected = walk_of(start, settings).frames;
  ASSERT_EQ(expected.size(), 28U);
  for (std::size_t f = 0; f < expected.size(); ++f) {
    EXPECT_EQ(expected[f].number, std::int64_t(f / 7));
    EXPECT_EQ(expected[f].walker, int(f % 7));
  }
  for (const int threads : {1, 2, 5})
    for (const int lanes : {0, 1, 3})
      for (const std::size_t waiting : {std::size_t{1}, std::size_t{1} << 30}) {
        settings.threads = threads;
        settings.lanes = lanes;
        settings.waiting_bytes = waiting;
        const Walked walked = walk_of(start, settings);
        ASSERT_EQ(walked.frames.size(), expected.size());
        for (std::size_t f = 0; f < expected.size(); ++f)
          expect_same(walked.frames[f], expected[f]);
        EXPECT_LE(walked.report.threads, threads);
      }
}

TEST(Walkers, RejectStepsAndCountThem) {
  const Walked walked = walk_of(heptane(), settings_for("ordered"));
  std::int64_t rejected = 0;
  for (const WalkerReport& walker : walked.report.walkers) {
    EXPECT_EQ(walker.steps, 12 + walker.rejected_steps);
    EXPECT_EQ(std::int64_t(walker.iterations.size()), walker.steps);
    EXPECT_EQ(walker.last_rejection.empty(), walker.rejected_steps == 0);
    rejected += walker.rejected_steps;
  }
  EXPECT_GT(rejected, 0);
}

TEST(Walkers, EndWhenTheirStepsAreUsedUp) {
  WalkSettings settings = settings_for("ordered");
  settings.resolver.max_iterations = 1;
  settings.motion.size = 0.1;
  for (const int threads : {1, 3}) {
    settings.threads = threads;
    const Walked walked = walk_of(heptane(), settings);
    EXPECT_TRUE(walked.frames.empty());
    for (const WalkerReport& walker : walked.report.walkers) {
      EXPECT_EQ(walker.steps, 120);
      EXPECT_EQ(walker.rejected_steps, 120);
      EXPECT_EQ(walker.last_rejection.substr(0, 22), "maximum of iterations:");
    }
  }
}

TEST(Walkers, WithFewAttemptsGiveTheFramesTheyHaveInOrder) {
  WalkSettings settings = settings_for("ordered");
  settings.attempts = 1;
  const Walked walked = walk_of(heptane(), settings);
  EXPECT_LT(walked.frames.size(), 28U);
  EXPECT_GT(walked.frames.size(), 7U);
  for (std::size_t f = 1; f < walked.frames.size(); ++f)
    EXPECT_LT(std::pair(walked.frames[f - 1].number, walked.frames[f - 1].walker),
              std::pair(walked.frames[f].number, walked.frames[f].walker));
}

TEST(Walkers, LeaveMasslessAndFixedJointsInPlace) {
  Start start = heptane();
  FrameworkParts parts = start.framework->parts();
  parts.masses[0] = 0;
  parts.fixed[5] = 1;
  start.framework = std::make_shared<const Framework>(std::move(parts));
  WalkSettings settings = settings_for("ordered");
  settings.resolver.max_iterations = 1000;
  const Walked walked = walk_of(start, settings);
  EXPECT_EQ(walked.frames.size(), 28U);
  for (const WalkFrame& frame : walked.frames) {
    EXPECT_EQ(frame.positions[0], start.positions[0]);
    EXPECT_EQ(frame.positions[5], start.positions[5]);
    EXPECT_NE(frame.positions[1], start.positions[1]);
  }
}

TEST(Walkers, StopWhenAskedAndGiveWhatIsDone) {
  const Start start = heptane();
  WalkSettings settings = settings_for("ordered");
  settings.frames = 1000000;
  std::vector<WalkFrame> frames;
  const WalkReport report = walk(
      start.framework, start.positions, settings, nullptr,
      [&](const WalkFrame& frame) { frames.push_back(frame); }, [&] { return frames.size() < 20; });
  EXPECT_TRUE(report.interrupted);
  std::int64_t made = 0;
  for (const WalkerReport& walker : report.walkers) made += walker.frames;
  EXPECT_EQ(std::int64_t(frames.size()), made);
  EXPECT_GE(made, 20);
}

TEST(Walkers, CarryOverWhatTheTakerThrows) {
  const Start start = heptane();
  WalkSettings settings = settings_for("ordered");
  settings.frames = 1000000;
  EXPECT_THROW(walk(start.framework, start.positions, settings, nullptr,
                    [](const WalkFrame&) { throw std::runtime_error("no room"); }),
               std::runtime_error);
}

TEST(Walkers, RefuseSettingsThatMakeNoSense) {
  const Start start = heptane();
  const auto refusal = [&](auto change) {
    WalkSettings settings = settings_for("ordered");
    change(settings);
    return refusal_of([&] { walk_of(start, settings); });
  };
  EXPECT_EQ(refusal([](WalkSettings& s) { s.walkers = 0; }),
            "the number of walkers must be 1 or more");
  EXPECT_EQ(refusal([](WalkSettings& s) { s.stride = 0; }),
            "frames, stride and attempts of a walk must be 1 or more");
  EXPECT_EQ(refusal([](WalkSettings& s) { s.threads = -1; }),
            "the number of threads must be 0 or more");
  EXPECT_EQ(refusal([](WalkSettings& s) { s.motion.size = -1; }),
            "the size of the perturbation must be 0 nm or more");
  EXPECT_EQ(refusal([](WalkSettings& s) { s.resolver.tolerance = 0; }),
            "the tolerance must be a positive number");
  EXPECT_EQ(refusal_of([&] {
              walk_of({start.framework, {}}, settings_for("ordered"));
            }),
            "there are 0 positions for 23 joints");
}

}  // namespace
}  // namespace ragdoll
