// Tests for core/src/force_run.cpp, and for the orders of our own that it is used to compare.

#include <gtest/gtest.h>

#include <algorithm>  // max, reverse
#include <cmath>      // abs, isfinite
#include <limits>

#include "examples.h"  // refusal_of
#include "ragdoll/force_run.h"
#include "ragdoll/generate.h"

namespace ragdoll {
namespace {

// === The specification once more, as plainly as it can be written

struct NaiveVisit {
  std::size_t bar;
  int near, far;
  bool problem;
};

/// Breadth-first from the root; a problem constraint comes when the second of its ends is taken off
/// the queue.
std::vector<NaiveVisit> naive_order(const Structure& structure, int root) {
  const std::size_t n = structure.positions.size();
  const std::vector<Bar>& bars = structure.parts.bars;
  std::vector<int> depth(n, -1);
  std::vector<bool> taken(n, false), used(bars.size(), false);
  std::vector<NaiveVisit> order;
  std::vector<int> queue = {root};
  depth[std::size_t(root)] = 0;
  for (std::size_t head = 0; head < queue.size(); ++head) {
    const int joint = queue[head];
    taken[std::size_t(joint)] = true;
    for (std::size_t k = 0; k < bars.size(); ++k) {
      if (used[k] || (bars[k].p != joint && bars[k].q != joint)) continue;
      const int other = bars[k].p == joint ? bars[k].q : bars[k].p;
      if (depth[std::size_t(other)] < 0) {
        depth[std::size_t(other)] = depth[std::size_t(joint)] + 1;
        queue.push_back(other);
        order.push_back({k, joint, other, false});
        used[k] = true;
      } else if (taken[std::size_t(other)]) {
        order.push_back({k, bars[k].p, bars[k].q, true});
        used[k] = true;
      }
    }
  }
  return order;
}

struct NaiveRun {
  std::vector<std::int64_t> iterations;
  std::vector<bool> converged;
  std::vector<std::vector<Vec3>> frames;
};

NaiveRun naive_run(const Structure& structure, const ForceSet& set, Weighting weighting, bool all,
                   bool back_and_forth) {
  NaiveRun run;
  std::vector<Vec3> x = structure.positions, x_old = x;
  const auto is_fixed = [&](int joint) { return structure.parts.fixed[std::size_t(joint)] != 0; };
  for (const Force& force : set.forces) {
    // break
    const std::vector<Vec3> before = x;
    for (int j = 0; j < int(x.size()); ++j) {
      const std::size_t i = std::size_t(j);
      if (is_fixed(j) || (!all && j != force.joint)) continue;
      const Vec3 a =
          j == force.joint ? Vec3(force.force / structure.parts.masses[i]) : Vec3(Vec3::Zero());
      x[i] = 2 * before[i] - x_old[i] + a * set.timestep * set.timestep;
    }
    x_old = before;
    // resolve
    std::vector<NaiveVisit> order = naive_order(structure, force.joint);
    if (back_and_forth) {
      std::vector<NaiveVisit> back(order.rbegin(), order.rend());
      order.insert(order.end(), back.begin(), back.end());
    }
    const auto broken = [&](const Bar& bar) {
      const double d = (x[std::size_t(bar.q)] - x[std::size_t(bar.p)]).norm();
      return std::abs(d - bar.length) > set.tolerance * bar.length;
    };
    const auto any_broken = [&] {
      return std::any_of(structure.parts.bars.begin(), structure.parts.bars.end(), broken);
    };
    std::int64_t iterations = 0;
    while (any_broken() && iterations < set.max_iterations) {
      ++iterations;
      for (const NaiveVisit& visit : order) {
        const Bar& bar = structure.parts.bars[visit.bar];
        if (!broken(bar)) continue;
        Vec3 &p = x[std::size_t(visit.near)], &q = x[std::size_t(visit.far)];
        double w_p = visit.problem ? 0.5 : weighting.near,
               w_q = visit.problem ? 0.5 : weighting.far;
        if (is_fixed(visit.near)) w_p = 0, w_q = 1;
        if (is_fixed(visit.far)) w_p = 1, w_q = 0;
        const Vec3 d = q - p;
        const double error = bar.length - d.norm();
        const Vec3 unit = d / d.norm();
        p -= w_p * error * unit;
        q += w_q * error * unit;
      }
    }
    run.iterations.push_back(iterations);
    run.converged.push_back(!any_broken());
    run.frames.push_back(x);
  }
  return run;
}

// === Helpers

const Weighting weightings[] = {{0.5, 0.5}, {0.25, 0.75}, {0, 1}};

Structure structure_of_class(const std::string& name, std::uint64_t seed, int joints = 14) {
  StructureRequest request;
  request.class_name = name;
  request.joints = joints;
  request.seed = seed;
  return generate_structure(request);
}

ForceRun run_with(const Structure& structure, const ForceSet& forces, OrderKind order,
                  Weighting weighting, VerletScope verlet = VerletScope::affected) {
  ForceRunSettings settings = {.resolver = {.solver = "ordered"}};
  settings.resolver.order = order;
  settings.resolver.weighting = weighting;
  settings.verlet = verlet;
  settings.frames = true;
  return run_forces(structure, forces, settings);
}

double farthest_apart(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double farthest = 0;
  for (std::size_t j = 0; j < a.size(); ++j) farthest = std::max(farthest, (a[j] - b[j]).norm());
  return farthest;
}

template <class Check>
void for_runs(const std::vector<std::string>& classes, Check check) {
  for (const std::string& name : classes)
    for (std::uint64_t seed = 0; seed < 6; ++seed)
      for (const Weighting& weighting : weightings) {
        const Structure structure = structure_of_class(name, seed);
        ForceSet forces = generate_forces(structure, {.count = 8, .seed = seed});
        forces.max_iterations = 500;
        SCOPED_TRACE(name + " " + std::to_string(seed) + " " + name_of(weighting));
        check(structure, forces, weighting);
      }
}

const std::vector<std::string> thesis_classes = {"tree", "1-cycle", "2-cycle", "n-cycle"};

// === Against the specification

TEST(ForceRun, AgreesWithThePlainSpecificationForceAfterForce) {
  for_runs(thesis_classes, [](const Structure& s, const ForceSet& forces, Weighting weighting) {
    for (const bool all : {false, true}) {
      for (const bool reverse : {false, true}) {
        const NaiveRun naive = naive_run(s, forces, weighting, all, reverse);
        const ForceRun run =
            run_with(s, forces, reverse ? OrderKind::bfs_reverse : OrderKind::bfs_cycle, weighting,
                     all ? VerletScope::all : VerletScope::affected);
        for (std::size_t k = 0; k < forces.forces.size(); ++k) {
          // an unresolved force may multiply rounding without bound
          if (!naive.converged[k]) break;
          ASSERT_EQ(run.reports[k].iterations, naive.iterations[k]) << k;
          ASSERT_TRUE(run.reports[k].converged);
          ASSERT_LT(farthest_apart(run.frames[k], naive.frames[k]), 1e-9) << k;
        }
      }
    }
  });
}

TEST(ForceRun, FixedJointsStayAndTheirPartnersTakeTheWholeError) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Structure structure = structure_of_class("1-cycle", seed);
    structure.parts.fixed[0] = structure.parts.fixed[7] = 1;
    for (double& mass : structure.parts.masses) mass = 2.5;
    ForceSet forces = generate_forces(structure, {.count = 5, .lo = 0.05, .hi = 0.2, .seed = seed});
    forces.timestep = 0.7;
    const NaiveRun naive = naive_run(structure, forces, {0.25, 0.75}, true, false);
    const ForceRun run =
        run_with(structure, forces, OrderKind::bfs_cycle, {0.25, 0.75}, VerletScope::all);
    EXPECT_EQ(run.positions[0], structure.positions[0]);
    EXPECT_EQ(run.positions[7], structure.positions[7]);
    for (std::size_t k = 0; k < 5 && naive.converged[k]; ++k) {
      EXPECT_EQ(run.reports[k].iterations, naive.iterations[k]);
      EXPECT_LT(farthest_apart(run.frames[k], naive.frames[k]), 1e-9);
    }
  }
}

TEST(ForceRun, JointKeepsTheVelocityOfItsLastStep) {
  // a joint without bars: only Verlet moves it
  Structure structure;
  structure.ids = {"a", "b", "c"};
  structure.positions = {{0, 0, 0}, {5, 0, 0}, {6, 0, 0}};
  structure.parts.masses = {2, 1, 1};
  structure.parts.bars = {{1, 2, 1}};
  ForceSet forces;
  forces.forces = {{0, {2, 0, 0}}, {0, {0, 2, 0}}, {1, {0, 0, 0}}, {0, {0, 0, 2}}};
  const ForceRun affected = run_with(structure, forces, OrderKind::bfs_cycle, {});
  // 1 in x; then 1 in x again and 1 in y; then another joint's turn, after which it is at rest
  EXPECT_EQ(affected.frames[0][0], Vec3(1, 0, 0));
  EXPECT_EQ(affected.frames[1][0], Vec3(2, 1, 0));
  EXPECT_EQ(affected.frames[2][0], Vec3(2, 1, 0));
  EXPECT_EQ(affected.frames[3][0], Vec3(2, 1, 1));
  const ForceRun all = run_with(structure, forces, OrderKind::bfs_cycle, {}, VerletScope::all);
  EXPECT_EQ(all.frames[2][0], Vec3(3, 2, 0));
  EXPECT_EQ(all.frames[3][0], Vec3(4, 3, 1));
}

TEST(ForceRun, ForceOfZeroStillMovesTheJointItActsOn) {
  Structure structure;
  structure.ids = {"a"};
  structure.positions = {{0, 0, 0}};
  structure.parts.masses = {1};
  ForceSet forces;
  forces.forces = {{0, {1, 0, 0}}, {0, {0, 0, 0}}};
  EXPECT_EQ(run_with(structure, forces, OrderKind::bfs_cycle, {}).positions[0], Vec3(2, 0, 0));
}

// === What a run reports

TEST(ForceRun, UnresolvedForceLeavesTheJointsForTheNextOne) {
  const Structure structure = structure_of_class("n-cycle", 5, 20);
  ForceSet forces = generate_forces(structure, {.count = 6, .seed = 1});
  forces.max_iterations = 1;
  const ForceRun run = run_with(structure, forces, OrderKind::bfs_cycle, {});
  const NaiveRun naive = naive_run(structure, forces, {}, false, false);
  for (std::size_t k = 0; k < 6; ++k) {
    EXPECT_EQ(run.reports[k].iterations, 1);
    EXPECT_FALSE(run.reports[k].converged);
    EXPECT_EQ(run.reports[k].reason, StopReason::max_iterations);
    EXPECT_GT(run.reports[k].residual, forces.tolerance);
    EXPECT_LT(farthest_apart(run.frames[k], naive.frames[k]), 1e-9);
  }
  EXPECT_NE(run.reports[5].worst.find("j"), std::string::npos);
}

TEST(ForceRun, LimitsAreThoseOfTheForces) {
  const Structure structure = structure_of_class("2-cycle", 1);
  ForceSet forces = generate_forces(structure, {.count = 5, .seed = 1});
  ForceRunSettings settings = {.resolver = {.solver = "ordered"}};
  settings.resolver.tolerance = 0.5;
  settings.resolver.max_iterations = 1;
  forces.tolerance = 1e-7;
  for (const ResolveReport& report : run_forces(structure, forces, settings).reports) {
    EXPECT_TRUE(report.converged);
    EXPECT_LE(report.residual, 1e-7);
  }
}

TEST(ForceRun, ReportsAndFramesAreOnePerForceAndTheLastFrameIsTheEnd) {
  const Structure structure = structure_of_class("1-cycle", 1);
  const ForceSet forces = generate_forces(structure, {.count = 7, .seed = 1});
  const ForceRun run = run_with(structure, forces, OrderKind::dfs_cycle, {});
  EXPECT_EQ(run.reports.size(), 7u);
  ASSERT_EQ(run.frames.size(), 7u);
  EXPECT_EQ(run.frames.back(), run.positions);
  EXPECT_TRUE(run_forces(structure, forces).frames.empty());
}

TEST(ForceRun, RandomOrdersAreThoseOfTheSeedAndOfTheForcesNumber) {
  const Structure structure = structure_of_class("2-cycle", 3, 20);
  const ForceSet forces = generate_forces(structure, {.count = 10, .seed = 1});
  ForceRunSettings settings = {.resolver = {.solver = "ordered"}};
  settings.resolver.order = OrderKind::random;
  const ForceRun first = run_forces(structure, forces, settings);
  EXPECT_EQ(first.positions, run_forces(structure, forces, settings).positions);
  settings.resolver.seed = 1;
  EXPECT_NE(first.positions, run_forces(structure, forces, settings).positions);
}

TEST(ForceRun, CustomOrderReplacesTheNamedOne) {
  const Structure structure = structure_of_class("tree", 3);
  ForceSet forces = generate_forces(structure, {.count = 1, .seed = 1});
  Random random(0, RandomStream::order, 0);
  const int root = forces.forces[0].joint;
  ForceRunSettings settings = {.resolver = {.solver = "ordered"}};
  settings.resolver.weighting = {0, 1};
  settings.resolver.order = OrderKind::random;
  settings.resolver.custom_order =
      order_of(framework_of(structure)->graph(), OrderKind::dfs_cycle, {&root, 1}, random);
  const ForceRun run = run_forces(structure, forces, settings);
  EXPECT_EQ(run.reports[0].iterations, 1);
  EXPECT_EQ(run.positions, run_with(structure, forces, OrderKind::dfs_cycle, {0, 1}).positions);
}

TEST(ForceRun, ProgressIsToldAndCanStopTheRun) {
  const Structure structure = structure_of_class("tree", 3);
  const ForceSet forces = generate_forces(structure, {.count = 9, .seed = 1});
  std::vector<std::size_t> told;
  ForceRunSettings settings = {.resolver = {.solver = "ordered"}};
  settings.progress = [&](std::size_t done) {
    told.push_back(done);
    return done < 4;
  };
  EXPECT_EQ(run_forces(structure, forces, settings).reports.size(), 4u);
  EXPECT_EQ(told, (std::vector<std::size_t>{1, 2, 3, 4}));
}

TEST(ForceRun, ResolversThatTellWhatMovedGiveTheSameRun) {
  // the same loop without what they tell: all positions are copied
  const Structure structure = generate_structure({.class_name = "2-cycle", .joints = 40});
  const ForceSet forces = generate_forces(structure, {.count = 80});
  const ForceRunSettings settings = {.resolver = {.solver = "block"}, .frames = true};
  const ForceRun run = run_forces(structure, forces, settings);
  const auto framework = framework_of(structure);
  const auto resolver = make_resolver(framework, {.solver = "block"});
  std::vector<Vec3> x = structure.positions, x_old = x;
  for (std::size_t k = 0; k < forces.forces.size(); ++k) {
    const Force& force = forces.forces[k];
    const auto j = std::size_t(force.joint);
    const std::vector<Vec3> before = x;
    x[j] = 2 * x[j] - x_old[j] + force.force / framework->masses()[j];
    x_old = before;
    const ResolveReport report = resolver->resolve(x, {.roots = {&force.joint, 1}, .step = k});
    EXPECT_EQ(run.frames[k], x) << k;
    EXPECT_EQ(run.reports[k].bar_visits, report.bar_visits);
  }
}

TEST(ForceRun, BadForcesAreRefused) {
  const Structure structure = structure_of_class("tree", 3);
  const auto refused = [&](const ForceSet& forces) {
    return examples::refusal_of([&] { run_forces(structure, forces); });
  };
  ForceSet forces;
  forces.forces = {{14, {1, 0, 0}}};
  EXPECT_EQ(refused(forces), "force 0 acts on joint 14, but there are 14");
  forces.forces = {{2, {1, std::numeric_limits<double>::infinity(), 0}}};
  EXPECT_EQ(refused(forces), "force 0 on j2 is not a finite number");
  forces.forces.clear();
  forces.timestep = 0;
  EXPECT_EQ(refused(forces), "the timestep must be a positive number");
}

// === Orders of our own

TEST(BfsActive, MovesJointsExactlyAsBfsCycleWithNoMoreVisits) {
  std::int64_t active_visits = 0, cycle_visits = 0;
  for_runs(structure_classes(), [&](const Structure& s, ForceSet forces, Weighting weighting) {
    forces.max_iterations = 100;
    for (const VerletScope verlet : {VerletScope::affected, VerletScope::all}) {
      const ForceRun cycle = run_with(s, forces, OrderKind::bfs_cycle, weighting, verlet);
      const ForceRun active = run_with(s, forces, OrderKind::bfs_active, weighting, verlet);
      ASSERT_EQ(active.positions, cycle.positions);
      for (std::size_t k = 0; k < cycle.reports.size(); ++k) {
        ASSERT_EQ(active.reports[k].iterations, cycle.reports[k].iterations);
        ASSERT_EQ(active.reports[k].reason, cycle.reports[k].reason);
        ASSERT_EQ(active.reports[k].residual, cycle.reports[k].residual);
        ASSERT_LE(active.reports[k].bar_visits, cycle.reports[k].bar_visits);
        active_visits += active.reports[k].bar_visits;
        cycle_visits += cycle.reports[k].bar_visits;
      }
    }
  });
  EXPECT_LT(double(active_visits), 0.9 * double(cycle_visits));
}

TEST(BfsActive, FollowsTethersContactsAndFixedJoints) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Structure structure = structure_of_class("1-cycle", seed);
    structure.parts.fixed[2] = structure.parts.fixed[3] = 1;
    const std::vector<Vec3>& x = structure.positions;
    structure.parts.tethers = {{0, 9, 1.02 * (x[9] - x[0]).norm()}};
    structure.parts.contacts = {{4, 11, 0.98 * (x[11] - x[4]).norm()}};
    ForceSet forces = generate_forces(structure, {.count = 10, .seed = seed});
    forces.max_iterations = 200;
    const ForceRun cycle = run_with(structure, forces, OrderKind::bfs_cycle, {});
    const ForceRun active = run_with(structure, forces, OrderKind::bfs_active, {});
    ASSERT_EQ(active.positions, cycle.positions) << seed;
    for (std::size_t k = 0; k < 10; ++k)
      ASSERT_EQ(active.reports[k].iterations, cycle.reports[k].iterations);
  }
}

TEST(BfsActive, FollowsJointsThatTheCallerMoves) {
  const Structure structure = structure_of_class("2-cycle", 8);
  const auto framework = framework_of(structure);
  ResolverSettings cycle_settings, active_settings;
  active_settings.order = OrderKind::bfs_active;
  const auto cycle = make_resolver(framework, cycle_settings);
  const auto active = make_resolver(framework, active_settings);
  std::vector<Vec3> a = structure.positions, b = a;
  Random random(1, RandomStream::perturbation, 0);
  for (int step = 0; step < 20; ++step) {
    const std::size_t joint = random.below(a.size());
    const Vec3 move(random.uniform(), 0.1, -0.2);
    a[joint] += move;
    b[joint] += move;
    const ResolveReport of_a = cycle->resolve(a, {}), of_b = active->resolve(b, {});
    EXPECT_EQ(of_a.iterations, of_b.iterations);
    EXPECT_EQ(a, b);
  }
}

TEST(BfsWorst, ResolvesTreesInOneIterationWithFullWeightOutward) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Structure structure = structure_of_class("tree", seed, 30);
    const ForceSet forces = generate_forces(structure, {.count = 10, .seed = seed});
    for (const ResolveReport& report :
         run_with(structure, forces, OrderKind::bfs_worst, {0, 1}).reports) {
      EXPECT_TRUE(report.converged);
      EXPECT_EQ(report.iterations, 1);
    }
  }
}

TEST(BfsWorst, ResolvesWhatBfsCycleWithFullWeightOutwardDoesNot) {
  std::int64_t failed = 0, worst_iterations = 0, reverse_iterations = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const Structure structure = structure_of_class("2-cycle", seed, 20);
    ForceSet forces = generate_forces(structure, {.count = 20, .seed = seed});
    forces.max_iterations = 1000;
    for (const ResolveReport& report :
         run_with(structure, forces, OrderKind::bfs_cycle, {0, 1}).reports)
      failed += !report.converged;
    for (const ResolveReport& report :
         run_with(structure, forces, OrderKind::bfs_reverse, {}).reports)
      reverse_iterations += report.iterations;
    for (const ResolveReport& report :
         run_with(structure, forces, OrderKind::bfs_worst, {0, 1}).reports) {
      EXPECT_TRUE(report.converged);
      worst_iterations += report.iterations;
    }
  }
  EXPECT_GT(failed, 0);
  EXPECT_LT(worst_iterations, reverse_iterations);
}

TEST(BfsWorst, SharesEvenlyInDenseBlocksWhateverTheWeighting) {
  const Structure structure = structure_of_class("cloth", 3, 20);
  const ForceSet forces = generate_forces(structure, {.count = 5, .hi = 0.3, .seed = 1});
  EXPECT_EQ(run_with(structure, forces, OrderKind::bfs_worst, {0, 1}).positions,
            run_with(structure, forces, OrderKind::bfs_worst, {0.5, 0.5}).positions);
}

}  // namespace
}  // namespace ragdoll
