// Tests for core/src/work_list.h and ordered_passes.cpp: bars that nothing moved are left out, and
// nothing else changes.

#include <gtest/gtest.h>

#include <algorithm>  // count

#include "ordered_examples.h"
#include "rank_set.h"
#include "sweep_order.h"  // SweepOrder
#include "work_list.h"    // WorkList

namespace ragdoll {
namespace {

using namespace examples;

constexpr OrderKind lasting_kinds[] = {OrderKind::bfs_tree,    OrderKind::dfs_tree,
                                       OrderKind::bfs_cycle,   OrderKind::dfs_cycle,
                                       OrderKind::bfs_reverse, OrderKind::dfs_reverse};

void expect_same_end(const ResolveReport& plain, const ResolveReport& listed) {
  EXPECT_EQ(listed.iterations, plain.iterations);
  EXPECT_EQ(listed.converged, plain.converged);
  EXPECT_EQ(listed.reason, plain.reason);
  EXPECT_EQ(listed.residual, plain.residual);
  EXPECT_EQ(listed.residual_nm, plain.residual_nm);
  EXPECT_EQ(listed.worst, plain.worst);
  EXPECT_LE(listed.bar_visits, plain.bar_visits);
}

TEST(RankSet, FindsTheNextNumberAsASearchDoes) {
  Random random = dice(31);
  for (const std::size_t size : {1U, 63U, 64U, 65U, 5000U, 300000U}) {
    RankSet set;
    set.resize(size);
    std::vector<bool> holds(size, false);
    for (int change = 0; change < 300; ++change) {
      const std::size_t number = random.below(size);
      if (change % 3 == 0)
        set.erase(number);
      else
        set.insert(number);
      holds[number] = change % 3 != 0;
      const std::size_t from = random.below(size);
      std::size_t expected = from;
      while (expected < size && !holds[expected]) ++expected;
      EXPECT_EQ(set.next(from), expected == size ? RankSet::none : expected);
    }
    EXPECT_EQ(set.next(size), RankSet::none);
  }
}

TEST(OrderedWorkList, ChangesNothingButTheVisits) {
  Random random = dice(32);
  std::int64_t all_plain = 0, all_listed = 0;
  for (const OrderKind kind : lasting_kinds)
    for (const Weighting& weighting : weightings)
      for (int round = 0; round < 12; ++round) {
        const Structure structure =
            random_structure(30, is_tree_order(kind) ? 0 : round % 4, random);
        ResolverSettings settings = {.solver = "ordered",
                                     .order = kind,
                                     .weighting = weighting,
                                     .tolerance = 1e-4,
                                     .max_iterations = 60};
        const auto plain = make_resolver(framework_of(structure.parts), settings);
        settings.work_list = true;
        const auto listed = make_resolver(framework_of(structure.parts), settings);
        Positions x = structure.positions, y = x;
        for (int force = 0; force < 12; ++force) {
          // the same root now and then, none now and then, and joints that are no roots
          std::vector<int> roots = {force % 4 == 1 ? 3 : int(random.below(30))};
          x[std::size_t(roots[0])] += 0.5 * random_vector(random);
          if (force % 5 == 2) x[9] += 0.3 * random_vector(random);
          y = x;
          if (force % 6 == 5) roots.clear();
          const ResolveReport one = plain->resolve(x, {.roots = roots});
          const ResolveReport two = listed->resolve(y, {.roots = roots});
          expect_same_end(one, two);
          EXPECT_EQ(x, y) << name_of(kind);
          all_plain += one.bar_visits;
          all_listed += two.bar_visits;
        }
      }
  EXPECT_LT(all_listed, 0.8 * double(all_plain));
}

TEST(OrderedWorkList, OutwardOrdersAreToldNoFurtherThanBarsMoved) {
  // a chain of a thousand joints: what is told of an order lies about the root, on the way back too
  constexpr int joints = 1000;
  FrameworkParts parts;
  Positions x;
  parts.masses.assign(joints, 1.0);
  for (int j = 0; j < joints; ++j) {
    x.emplace_back(j, 0, 0);
    if (j > 0) parts.bars.push_back({j - 1, j, 1});
  }
  const Framework framework(parts);
  for (const OrderKind kind : {OrderKind::bfs_cycle, OrderKind::bfs_reverse}) {
    SweepOrder order(framework, {.solver = "ordered", .order = kind});
    ASSERT_TRUE(order.by_visit());
    EXPECT_EQ(order.and_back(), kind == OrderKind::bfs_reverse);
    WorkList<double> list(framework.graph());
    for (int bar = 0; bar < joints - 1; ++bar) list.settle(bar);
    const int root = 500;
    order.start({&root, 1});
    list.start_over(parts.bars.size(), order.and_back());
    list.move(root);
    int told = 0;
    for (Visit visit; list.expects_places() && order.next(visit); ++told) list.append(visit.bar);
    EXPECT_EQ(told, 2);
    EXPECT_EQ(list.next(0), 0U);
    EXPECT_EQ(list.next(1), 1U);
    // 999 bars: the way back ends at the first
    EXPECT_EQ(list.next(2), order.and_back() ? 2 * 999U - 2 : RankSet::none);
    EXPECT_EQ(list.appended_at(order.and_back() ? 2 * 999 - 2 : 1), 1U);
  }
}

TEST(OrderedWorkList, ChangesNothingWhereOnlyRootsMovedIsPromised) {
  Random random = dice(33);
  int told = 0;
  for (const OrderKind kind : lasting_kinds)
    for (const Weighting& weighting : weightings)
      for (int round = 0; round < 8; ++round) {
        Structure structure = random_structure(30, is_tree_order(kind) ? 0 : round % 4, random);
        structure.parts.fixed.assign(30, 0);
        structure.parts.fixed[2] = round % 2 == 0;
        ResolverSettings settings = {.solver = "ordered",
                                     .order = kind,
                                     .weighting = weighting,
                                     .tolerance = 1e-3,
                                     .max_iterations = 1000};
        const auto plain = make_resolver(framework_of(structure.parts), settings);
        settings.work_list = true;
        const auto listed = make_resolver(framework_of(structure.parts), settings);
        Positions x = structure.positions;
        for (int force = 0; force < 12; ++force) {
          const Positions before = x;
          const std::vector<int> roots = {force % 4 == 1 ? 3 : int(random.below(30)), 4};
          x[std::size_t(roots[0])] += (force % 5 == 4 ? 1e-5 : 0.2) * random_vector(random);
          if (force % 3 == 0) x[4] += 0.2 * random_vector(random);
          Positions y = x;
          const ResolveReport one = plain->resolve(x, {.roots = roots});
          const ResolveReport two = listed->resolve(y, {.roots = roots, .only_roots_moved = true});
          expect_same_end(one, two);
          EXPECT_EQ(x, y) << name_of(kind);
          const std::vector<int>* const moved = listed->moved_joints();
          for (std::size_t j = 0; moved && j < x.size(); ++j) {
            if (y[j] == before[j]) continue;
            EXPECT_NE(std::count(moved->begin(), moved->end(), int(j)), 0);
          }
          told += moved != nullptr;
          if (!one.converged) x = before;
        }
      }
  EXPECT_GT(told, 500);
}

TEST(OrderedWorkList, ChangesNothingBesideOtherConstraints) {
  Random random = dice(34);
  for (const OrderKind kind : lasting_kinds) {
    Structure structure = random_structure(20, is_tree_order(kind) ? 0 : 2, random);
    const auto distance = [&](std::size_t p, std::size_t q) {
      return (structure.positions[p] - structure.positions[q]).norm();
    };
    structure.parts.tethers = {{0, 7, distance(0, 7)}};
    structure.parts.contacts = {{3, 9, distance(3, 9)}};
    structure.parts.contact_rule.radii.assign(20, 0.03);
    structure.parts.contact_rule.polarity.assign(20, Polarity::none);
    structure.parts.contact_rule.scale = 1;
    structure.parts.contact_rule.exclusion_begin.assign(21, 0);
    ResolverSettings settings = {.solver = "ordered", .order = kind, .max_iterations = 200};
    const auto plain = make_resolver(framework_of(structure.parts), settings);
    settings.work_list = true;
    const auto listed = make_resolver(framework_of(structure.parts), settings);
    for (int force = 0; force < 10; ++force) {
      Positions x = structure.positions;
      x[std::size_t(force)] += 0.5 * random_vector(random);
      Positions y = x;
      const std::vector<int> roots = {force};
      const ResolveReport one = plain->resolve(x, {.roots = roots});
      expect_same_end(one, listed->resolve(y, {.roots = roots, .only_roots_moved = true}));
      EXPECT_EQ(x, y);
    }
  }
}

TEST(OrderedWorkList, VisitsOfOneForcedJointDoNotGrowWithTheStructure) {
  const auto visits = [](int joints) {
    FrameworkParts parts;
    Positions x;
    parts.masses.assign(std::size_t(joints), 1);
    for (int j = 0; j < joints; ++j) {
      x.emplace_back(0.8 * j, j % 2 ? 0.6 : 0, 0);
      if (j > 0) parts.bars.push_back({j - 1, j, 1});
    }
    const auto resolver = make_resolver(
        framework_of(parts), {.solver = "ordered", .tolerance = 1e-2, .work_list = true});
    resolver->resolve(x, {});
    std::vector<std::int64_t> counts;
    for (const int root : {joints / 2, joints / 4, 1}) {
      x[std::size_t(root)] += Vec3(0.3, 0.2, -0.4);
      counts.push_back(
          resolver->resolve(x, {.roots = {&root, 1}, .only_roots_moved = true}).bar_visits);
    }
    return counts;
  };
  EXPECT_EQ(visits(1000), visits(40000));
  EXPECT_LE(visits(1000)[0], 200);
}

TEST(OrderedWorkList, ForgetsPromisesAfterABreakThatWasNotResolved) {
  const FrameworkParts parts = parts_of("ab bc cd", {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}});
  const auto resolver = make_resolver(
      framework_of(parts),
      {.solver = "ordered", .tolerance = 1e-3, .max_iterations = 1, .work_list = true});
  Positions x = on_axis({-2, 1, 2, 3});
  const int root = 0;
  EXPECT_FALSE(resolver->resolve(x, {.roots = {&root, 1}}).converged);
  Positions y = x;
  const ResolveReport one = resolve(parts, y, {.tolerance = 1e-3, .max_iterations = 1}, {0});
  expect_same_end(one, resolver->resolve(x, {.roots = {&root, 1}, .only_roots_moved = true}));
  EXPECT_EQ(x, y);
  x[2][0] = nan;
  EXPECT_EQ(resolver->resolve(x, {.roots = {&root, 1}, .only_roots_moved = true}).reason,
            StopReason::not_finite);
}

}  // namespace
}  // namespace ragdoll
