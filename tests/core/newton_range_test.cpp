// Tests for core/src/newton_range.cpp, and of tethers and contacts far across, which are no rows of
// the pattern of `newton`: they hold all the same.

#include <gtest/gtest.h>

#include <algorithm>  // max
#include <cstring>    // memcmp
#include <string>

#include "examples.h"
#include "newton_plan.h"
#include "newton_range.h"
#include "ragdoll/ensemble_resolver.h"  // make_ensemble_resolver, resolve_all
#include "ragdoll/resolver.h"           // make_resolver

namespace ragdoll {
namespace {

using namespace examples;

constexpr int joints = 360, conformers = 11;

/// A folded chain, 1-2 and 1-3 held, whose joints far along are tethered or kept apart; its joints
/// meet all of it.
Structure folded_chain() {
  Random random(1, RandomStream::generate, 7);
  Structure chain;
  chain.parts.masses.assign(std::size_t(joints), 1);
  chain.parts.fixed.assign(std::size_t(joints), 0);
  chain.parts.fixed[100] = 1;
  for (int j = 0; j < joints; ++j) {
    chain.parts.masses[std::size_t(j)] = 1 + j % 12;
    // back and forth in layers
    const int row = j / 12, column = j % 12, layer = row / 6;
    chain.positions.push_back(
        Vec3(row % 2 == 0 ? column : 11 - column, layer % 2 == 0 ? row % 6 : 5 - row % 6, layer) *
            0.15 +
        0.02 * random_vector(random));
  }
  const auto distance = [&chain](int p, int q) {
    return (chain.positions[std::size_t(p)] - chain.positions[std::size_t(q)]).norm();
  };
  for (int j = 0; j + 1 < joints; ++j) chain.parts.bars.push_back({j, j + 1, distance(j, j + 1)});
  for (int j = 0; j + 2 < joints; ++j) chain.parts.bars.push_back({j, j + 2, distance(j, j + 2)});
  for (int p = 0; p < joints; ++p)
    for (int q = p + 7; q < joints; ++q) {
      if (distance(p, q) > 0.2) continue;
      if ((p + q) % 3 == 0)
        chain.parts.contacts.push_back({p, q, distance(p, q)});
      else
        chain.parts.tethers.push_back({p, q, distance(p, q)});
    }
  return chain;
}

Positions broken(const Structure& chain, double size) {
  Random random(2, RandomStream::generate, 7);
  Positions x;
  for (int k = 0; k < conformers; ++k)
    for (std::size_t j = 0; j < chain.positions.size(); ++j)
      x.push_back(chain.positions[j] +
                  (chain.parts.fixed[j] ? 0 : size * (1 + k % 3)) * random_vector(random));
  return x;
}

TEST(NewtonRange, CountsBarsBetweenTheEnds) {
  FrameworkParts parts;
  parts.masses.assign(6, 1);
  parts.fixed = {0, 0, 0, 0, 0, 1};
  for (int j = 0; j < 3; ++j) parts.bars.push_back({j, j + 1, 1});
  parts.tethers = {{3, 1, 5}, {0, 3, 5}, {0, 4, 5}};
  parts.contacts = {{0, 2, 1}, {4, 5, 1}};
  const Framework framework(parts);
  NewtonRange range(framework);
  const auto covered = [&] {
    std::string all;
    for (std::size_t k = 0; k < 3; ++k) all += range.covers_tether(k) ? '1' : '0';
    for (std::size_t k = 0; k < 2; ++k) all += range.covers_contact(k) ? '1' : '0';
    return all;
  };
  EXPECT_EQ(covered(), "11111");
  range.set_reach(3);
  EXPECT_EQ(covered(), "11011");
  range.set_reach(2);
  EXPECT_EQ(covered(), "10011");
  range.set_reach(-1);  // a fixed joint has no block
  EXPECT_EQ(covered(), "00001");
}

TEST(NewtonRange, ConstraintsFarAcrossFillNoPattern) {
  const Structure chain = folded_chain();
  const Framework framework(chain.parts);
  const double most = NewtonPlan::most_products(framework.joint_count());
  const NewtonPlan plan(framework, most), whole(framework, most, true);
  EXPECT_GT(plan.far.size(), 200U);
  EXPECT_EQ(plan.pairs.size() + plan.far.size(), whole.pairs.size());
  EXPECT_TRUE(whole.far.empty());
  EXPECT_LT(plan.row.size(), whole.row.size() / 2);
}

TEST(NewtonRange, FewConstraintsThatCostLittleStayInThePattern) {
  FrameworkParts parts = folded_chain().parts;
  parts.tethers.resize(3);
  parts.contacts.resize(2);
  const Framework framework(parts);
  const NewtonPlan plan(framework, NewtonPlan::most_products(framework.joint_count()));
  EXPECT_TRUE(plan.far.empty());
}

TEST(NewtonRange, ConstraintsFarAcrossHoldInLanesAsInTheSingleRunBitForBit) {
  const Structure chain = folded_chain();
  const auto framework = std::make_shared<const Framework>(chain.parts);
  const Positions start = broken(chain, 0.01);
  for (const Precision precision : {Precision::double_, Precision::single})
    for (const bool mass_weights : {false, true})
      for (const Tolerance tolerance : {Tolerance(1e-2), Tolerance::nanometers(1e-4)}) {
        const ResolverSettings settings{.solver = "newton",
                                        .tolerance = tolerance,
                                        .precision = precision,
                                        .mass_weights = mass_weights};
        Positions one = start, two = start;
        const auto single = make_resolver(framework, settings);
        const auto ensemble = make_ensemble_resolver(framework, settings);
        const std::vector<ResolveReport> in_lanes = resolve_all(*ensemble, two);
        for (std::size_t k = 0; k < std::size_t(conformers); ++k) {
          const auto x = std::span(one).subspan(k * joints, joints);
          const ResolveReport report = single->resolve(x, {});
          EXPECT_TRUE(report.converged) << report.worst;
          const Violation worst = worst_violation(*framework, x, nullptr, tolerance);
          EXPECT_LE(tolerance.absolute() ? worst.nanometers : worst.relative, tolerance.value());
          EXPECT_NEAR(report.residual, worst.relative, 1e-12);
          EXPECT_NEAR(report.residual_nm, worst.nanometers, 1e-12);
          EXPECT_EQ(report.iterations, in_lanes[k].iterations);
          EXPECT_EQ(report.residual, in_lanes[k].residual);
          EXPECT_EQ(x[100], chain.positions[100]);
        }
        EXPECT_EQ(std::memcmp(one.data(), two.data(), one.size() * sizeof(Vec3)), 0);
      }
}

TEST(NewtonRange, WhatIsMetTakesNoIterationAndWhatCannotBeIsNamed) {
  Structure chain = folded_chain();
  Positions x = chain.positions;
  const auto resolve = [&] {
    return make_resolver(std::make_shared<const Framework>(chain.parts),
                         {.solver = "newton", .max_iterations = 200})
        ->resolve(x, {});
  };
  const ResolveReport met = resolve();
  EXPECT_EQ(met.reason, StopReason::nothing_broken);
  EXPECT_EQ(met.iterations, 0);
  EXPECT_EQ(x, chain.positions);
  // a whole row away from each other however it is folded
  chain.parts.contacts.push_back({0, 8, 5});
  const ResolveReport report = resolve();
  EXPECT_FALSE(report.converged);
  EXPECT_EQ(report.worst, worst_violation(Framework(chain.parts), x, nullptr).what);
}

}  // namespace
}  // namespace ragdoll
