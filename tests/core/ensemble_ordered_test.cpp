// Tests for core/src/ensemble_ordered.cpp and lane_sweep.cpp: each lane does what the single
// resolver does, bit for bit.

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cmath>    // abs
#include <cstring>  // memcmp
#include <set>
#include <string>

#include "ordered_examples.h"
#include "ragdoll/ensemble_resolver.h"

namespace ragdoll {
namespace {

using namespace examples;

/// Every kind of constraint, of which the positions satisfy all.
Structure with_everything(int joints, int cycles, Random& random) {
  Structure s = random_structure(joints, cycles, random);
  const auto distance = [&](int p, int q) {
    return (s.positions[std::size_t(p)] - s.positions[std::size_t(q)]).norm();
  };
  s.parts.fixed.assign(std::size_t(joints), 0);
  s.parts.fixed[1] = s.parts.fixed[7] = 1;
  for (int p = 0; p + 5 < joints; p += 3) {
    s.parts.tethers.push_back({p, p + 4, distance(p, p + 4)});
    s.parts.contacts.push_back({p + 1, p + 5, distance(p + 1, p + 5)});
  }
  for (int a = 0; a + 3 < joints; a += 4) {
    const auto at = [&](int k) { return s.positions[std::size_t(a + k)]; };
    const double volume = signed_volume(at(0), at(1), at(2), at(3));
    const double scale = std::abs(volume) + 0.01;
    if (volume > 0)
      s.parts.volumes.push_back({a, a + 1, a + 2, a + 3, 0.8 * volume, infinity, scale});
    else
      s.parts.volumes.push_back({a, a + 1, a + 2, a + 3, -infinity, 0.8 * volume, scale});
  }
  return s;
}

void add_contact_rule(FrameworkParts& parts, double radius) {
  const std::size_t joints = parts.masses.size();
  parts.contact_rule.radii.assign(joints, radius);
  parts.contact_rule.polarity.assign(joints, Polarity::none);
  parts.contact_rule.scale = 1;
  parts.contact_rule.exclusion_begin.assign(joints + 1, 0);
}

/// Conformers of one structure, each broken its own way, some not at all.
Positions broken_conformers(const Structure& structure, int count, double size, Random& random) {
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
                            const ResolverSettings& settings, int lanes, const Box* box = nullptr) {
  const auto framework = framework_of(parts);
  const std::size_t joints = parts.masses.size(), count = start.size() / joints;
  Positions single = start, together = start;
  std::vector<ResolveReport> reports;
  for (std::size_t k = 0; k < count; ++k)
    reports.push_back(
        make_resolver(framework, settings)
            ->resolve(std::span(single).subspan(k * joints, joints), {.step = k, .box = box}));
  const auto ensemble = make_ensemble_resolver(framework, settings, lanes);
  const std::vector<ResolveReport> in_lanes = resolve_all(*ensemble, together, 0, box);
  EXPECT_TRUE(same_bits(single, together)) << ensemble->instructions() << ", " << lanes;
  int resolved = 0;
  for (std::size_t k = 0; k < count; ++k) {
    expect_same(reports[k], in_lanes[k]);
    resolved += reports[k].converged;
  }
  return resolved;
}

/// Calls with each instruction set of the machine in turn.
template <class Call>
void for_each_instruction_set(Call call) {
  for (std::int64_t left = hwy::SupportedTargets(); left != 0; left &= left - 1) {
    hwy::SetSupportedTargetsForTest(left & -left);
    call();
    hwy::SetSupportedTargetsForTest(0);
  }
}

constexpr Precision precisions[] = {Precision::double_, Precision::single};

TEST(OrderedLanes, AreTheSingleResolverInEveryInstructionSet) {
  std::set<std::string> seen;
  for_each_instruction_set([&] {
    for (const Precision precision : precisions) {
      Random random = dice(1);
      const Structure structure = with_everything(24, 4, random);
      const Positions start = broken_conformers(structure, 37, 0.05, random);
      const ResolverSettings settings = {
          .solver = "ordered", .tolerance = 1e-3, .max_iterations = 300, .precision = precision};
      EXPECT_GT(expect_lanes_are_single(structure.parts, start, settings, 0), 20);
      seen.insert(make_ensemble_resolver(framework_of(structure.parts), settings)->instructions());
    }
  });
  // the best ones and the portable ones are among them
  const auto best = make_ensemble_resolver(framework_of(parts_of("ab", {{0, 0, 0}, {1, 0, 0}})),
                                           {.solver = "ordered"});
  EXPECT_EQ(seen.count(best->instructions()), 1U);
  EXPECT_EQ(seen.count("SCALAR") + seen.count("EMU128"), 1U);
}

TEST(OrderedLanes, AreTheSingleResolverWhateverTheirNumber) {
  Random random = dice(2);
  const Structure structure = with_everything(20, 3, random);
  const Positions start = broken_conformers(structure, 37, 0.05, random);
  for (const Precision precision : precisions)
    for (const int lanes : {1, 3, 8, 17, 50}) {
      const ResolverSettings settings = {
          .solver = "ordered", .max_iterations = 200, .precision = precision};
      EXPECT_EQ(make_ensemble_resolver(framework_of(structure.parts), settings, lanes)->lanes(),
                lanes);
      expect_lanes_are_single(structure.parts, start, settings, lanes);
    }
}

TEST(OrderedLanes, AreTheSingleResolverInEveryOrderAndWeighting) {
  for (const Precision precision : precisions)
    for (const OrderKind kind : all_kinds)
      for (const Weighting& weighting : weightings) {
        Random random = dice(3);
        const Structure structure = with_everything(12, is_tree_order(kind) ? 0 : 2, random);
        const Positions start = broken_conformers(structure, 12, 0.05, random);
        expect_lanes_are_single(structure.parts, start,
                                {.solver = "ordered",
                                 .order = kind,
                                 .weighting = weighting,
                                 .max_iterations = 60,
                                 .precision = precision},
                                0);
      }
}

TEST(OrderedLanes, AreTheSingleResolverWithContactsOfARule) {
  const Box box = {{0.9, 0, 0}, {0.1, 0.9, 0}, {0, 0.2, 0.9}};
  for (const Precision precision : precisions)
    for (const double size : {0.002, 0.05})
      for (const Box* const boxed : {(const Box*)nullptr, &box}) {
        Random random = dice(4);
        Structure structure = with_everything(24, 2, random);
        add_contact_rule(structure.parts, 0.03);
        const Positions start = broken_conformers(structure, 37, size, random);
        EXPECT_GT(
            expect_lanes_are_single(
                structure.parts, start,
                {.solver = "ordered", .max_iterations = 200, .precision = precision}, 0, boxed),
            10);
      }
}

/// So many joints in so little space that each pass moves nearly all of them far.
TEST(OrderedLanes, AreTheSingleResolverWhereJointsFlyAbout) {
  const std::size_t joints = 60;
  const Box box = {{1.5, 0, 0}, {0.1, 1.5, 0}, {0, 0.2, 1.5}};
  for (const Precision precision : precisions)
    for (const Box* const boxed : {(const Box*)nullptr, &box}) {
      Random random = dice(14);
      FrameworkParts parts;
      parts.masses.assign(joints, 1);
      add_contact_rule(parts, 0.08);
      Positions start;
      // some conformers fly about, some hardly move
      for (int k = 0; k < 5; ++k)
        for (const Vec3& point : random_points(int(joints), 0.2 + 0.2 * k, random))
          start.push_back(point);
      const ResolverSettings settings = {
          .solver = "ordered", .max_iterations = 6, .precision = precision};
      expect_lanes_are_single(parts, start, settings, 0, boxed);
      // nor does it matter what was resolved before
      const auto framework = framework_of(parts);
      const auto kept = make_resolver(framework, settings);
      for (std::size_t k = 0; k < 5; ++k) {
        Positions one(start.begin() + std::ptrdiff_t(k * joints),
                      start.begin() + std::ptrdiff_t((k + 1) * joints));
        Positions two = one;
        expect_same(kept->resolve(one, {.box = boxed}),
                    make_resolver(framework, settings)->resolve(two, {.box = boxed}));
        EXPECT_TRUE(same_bits(one, two));
      }
    }
}

TEST(OrderedLanes, AreTheSingleResolverWithAnAbsoluteTolerance) {
  Random random = dice(5);
  const Structure structure = with_everything(24, 3, random);
  const Positions start = broken_conformers(structure, 20, 0.05, random);
  for (const Precision precision : precisions)
    expect_lanes_are_single(structure.parts, start,
                            {.solver = "ordered",
                             .tolerance = Tolerance::nanometers(1e-4),
                             .max_iterations = 500,
                             .precision = precision},
                            0);
}

TEST(OrderedLanes, DoNotDependOnWhenTheOthersAreLoaded) {
  Random random = dice(6);
  Structure structure = with_everything(20, 3, random);
  add_contact_rule(structure.parts, 0.03);
  const std::size_t joints = 20;
  const Positions start = broken_conformers(structure, 9, 0.05, random);
  for (const Precision precision : precisions) {
    const auto framework = framework_of(structure.parts);
    const ResolverSettings settings = {
        .solver = "ordered", .max_iterations = 100, .precision = precision};
    const auto ensemble = make_ensemble_resolver(framework, settings, 4);
    const auto of = [&](std::size_t k) { return std::span(start).subspan(k * joints, joints); };
    std::vector<std::size_t> holds(4, 0);
    // one lane is loaded in each round, as soon as there is a free one
    std::size_t next = 0, finished = 0;
    std::vector<bool> loaded(4, false);
    while (finished < 9) {
      for (std::size_t lane = 0; lane < 4; ++lane)
        if (loaded[lane] && ensemble->done(int(lane))) {
          Positions single(of(holds[lane]).begin(), of(holds[lane]).end()), x(joints);
          const ResolveReport report = ensemble->unload(int(lane), x);
          expect_same(make_resolver(framework, settings)->resolve(single, {}), report);
          EXPECT_TRUE(same_bits(single, x));
          loaded[lane] = false;
          ++finished;
        }
      for (std::size_t lane = 0; lane < 4 && next < 9; ++lane)
        if (!loaded[lane]) {
          ensemble->load(int(lane), of(next), {});
          holds[lane] = next++;
          loaded[lane] = true;
          break;
        }
      ensemble->iterate();
      ensemble->iterate();
    }
  }
}

TEST(OrderedLanes, ResolveFromForcedJointsToo) {
  Random random = dice(7);
  const Structure structure = random_structure(15, 2, random);
  const auto framework = framework_of(structure.parts);
  for (const Precision precision : precisions) {
    const ResolverSettings settings = {.solver = "ordered", .precision = precision};
    const auto ensemble = make_ensemble_resolver(framework, settings, 2);
    const int root = 4;
    Positions x = structure.positions;
    x[4] += random_vector(random);
    Positions single = x;
    ensemble->load(1, x, {.roots = {&root, 1}});
    while (!ensemble->done(1)) ensemble->iterate();
    const ResolveReport report = ensemble->unload(1, x);
    expect_same(make_resolver(framework, settings)->resolve(single, {.roots = {&root, 1}}), report);
    EXPECT_TRUE(same_bits(single, x));
  }
}

TEST(OrderedLanes, CustomOrderThatLeavesABarOutIsNotConverged) {
  const FrameworkParts parts = parts_of("ab bc", {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}});
  const Positions start = {{-1, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 0, 0}, {1, 0, 0}, {2.5, 0, 0}};
  for (const Precision precision : precisions)
    EXPECT_EQ(expect_lanes_are_single(parts, start,
                                      {.solver = "ordered",
                                       .weighting = far_only,
                                       .max_iterations = 20,
                                       .custom_order = {{1, 1, 2, false}},
                                       .precision = precision},
                                      0),
              1);
}

TEST(OrderedLanes, PositionsThatAreNoNumbersDoNotReachTheOtherLanes) {
  Random random = dice(8);
  Structure structure = with_everything(16, 2, random);
  add_contact_rule(structure.parts, 0.03);
  Positions start = broken_conformers(structure, 8, 0.05, random);
  start[5][1] = nan;
  start[3 * 16 + 2] = Vec3(infinity, 0, 0);
  start[5 * 16 + 2] = Vec3(1e200, 0, 0);
  start[6 * 16 + 2] = Vec3(1e6, 1e6, -1e6);
  for (const Precision precision : precisions)
    EXPECT_LE(expect_lanes_are_single(
                  structure.parts, start,
                  {.solver = "ordered", .max_iterations = 50, .precision = precision}, 0),
              5);
}

TEST(OrderedLanes, DegenerateBreaksAreThoseOfTheSingleResolver) {
  // joints at one place, volumes on a line, a triangle that cannot be, bars between fixed joints
  FrameworkParts parts;
  parts.masses.assign(7, 1);
  parts.bars = {{0, 1, 1}, {1, 2, 1}, {2, 0, 5}, {3, 4, 1}, {4, 5, 1}, {5, 6, 1}};
  parts.volumes = {{3, 4, 5, 6, 0.1, infinity, 1}};
  Positions start(7, Vec3(1, 2, 3));
  for (int j = 0; j < 7; ++j) start.emplace_back(j, 0, 0);
  for (const Precision precision : precisions)
    for (const bool fixed : {false, true}) {
      if (fixed) parts.fixed = {1, 1, 0, 0, 0, 0, 0};
      EXPECT_EQ(
          expect_lanes_are_single(
              parts, start, {.solver = "ordered", .max_iterations = 40, .precision = precision}, 0),
          0);
    }
}

}  // namespace
}  // namespace ragdoll
