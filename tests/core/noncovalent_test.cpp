// Tests for core/src/noncovalent.cpp, by the frameworks that come of it.

#include "noncovalent.h"

#include <gtest/gtest.h>

#include <algorithm>  // count_if, find_if
#include <cmath>      // acos
#include <limits>
#include <memory>
#include <numbers>  // pi

#include "examples.h"
#include "molecules.h"
#include "peptides.h"
#include "ragdoll/break.h"            // perturb
#include "ragdoll/build_framework.h"  // build_framework
#include "ragdoll/error.h"            // Error
#include "ragdoll/geometry.h"         // GeometryCheck
#include "ragdoll/random.h"           // Random
#include "ragdoll/resolver.h"         // make_resolver

namespace ragdoll {
namespace {

using namespace examples;

constexpr double degree = std::numbers::pi / 180;

FrameworkOptions options_with(const ConstraintOptions& constraints = {}) {
  FrameworkOptions options;
  options.constraints = constraints;
  return options;
}

/// A formamide (atoms 0-5) whose H 4 points at the O 7 of another (6-11).
Molecule dimer(double donor_acceptor = 0.29) {
  const Molecule one = formamide();
  std::vector<Atom> atoms = one.atoms();
  std::vector<Bond> bonds = one.bonds();
  Positions x = one.positions();
  const Vec3 along = (x[4] - x[2]).normalized(), o = x[2] + donor_acceptor * along;
  // O=C at 130 degrees to the hydrogen, in the plane
  const double turn = 130 * degree;
  const Vec3 back = -along;
  const Vec3 to_carbon(std::cos(turn) * back.x() - std::sin(turn) * back.y(),
                       std::sin(turn) * back.x() + std::cos(turn) * back.y(), 0);
  const Vec3 from = (x[0] - x[1]).normalized();
  const double angle = std::atan2(to_carbon.y(), to_carbon.x()) - std::atan2(from.y(), from.x());
  for (const Vec3& p : one.positions()) {
    const Vec3 d = p - one.positions()[1];
    x.push_back(o + Vec3(std::cos(angle) * d.x() - std::sin(angle) * d.y(),
                         std::sin(angle) * d.x() + std::cos(angle) * d.y(), d.z()));
  }
  atoms.insert(atoms.end(), one.atoms().begin(), one.atoms().end());
  for (const Bond& bond : one.bonds()) bonds.push_back({bond.a + 6, bond.b + 6, bond.order});
  return Molecule(atoms, bonds, x);
}

double angle_at(const Positions& x, int a, int centre, int b) {
  const Vec3 u = x[std::size_t(a)] - x[std::size_t(centre)],
             v = x[std::size_t(b)] - x[std::size_t(centre)];
  return std::acos(u.normalized().dot(v.normalized())) / degree;
}

TEST(Noncovalent, PlainFrameworksHaveNothingOfIt) {
  const Framework framework = build_framework(dimer());
  EXPECT_TRUE(framework.tethers().empty());
  EXPECT_TRUE(framework.contacts().empty());
  EXPECT_TRUE(framework.held_bonds().empty());
}

TEST(Noncovalent, AHydrogenBondIsATetherAndTwoContacts) {
  const Molecule molecule = dimer();
  const Framework framework = build_framework(molecule, options_with());
  ASSERT_EQ(framework.held_bonds().size(), 1U);
  EXPECT_EQ(framework.held_bonds()[0].donor, 2);
  EXPECT_EQ(framework.held_bonds()[0].hydrogen, 4);
  EXPECT_EQ(framework.held_bonds()[0].acceptor, 7);
  EXPECT_LT(framework.held_bonds()[0].energy, -1 * kilojoule_per_kilocalorie);
  ASSERT_EQ(framework.tethers().size(), 1U);
  const Tether& tether = framework.tethers()[0];
  EXPECT_EQ(tether.kind, TetherKind::hydrogen_bond);
  EXPECT_EQ(std::pair(tether.p, tether.q), std::pair(4, 7));
  EXPECT_GT(tether.length, 0.19 + 1e-3);
  EXPECT_LT(tether.length, 0.25);
  ASSERT_EQ(framework.contacts().size(), 2U);
  EXPECT_EQ(std::pair(framework.contacts()[0].p, framework.contacts()[0].q), std::pair(2, 7));
  EXPECT_EQ(std::pair(framework.contacts()[1].p, framework.contacts()[1].q), std::pair(4, 6));
  EXPECT_EQ(worst_violation(framework, molecule.positions(), nullptr).relative, 0);
}

TEST(Noncovalent, ABondThatIsShakenStaysOneByTheCriteriaThatFoundIt) {
  const Molecule molecule = dimer();
  const double tolerance = 1e-3;
  const Framework nominal = build_framework(molecule, options_with());
  const auto framework = std::make_shared<const Framework>(tightened(nominal, tolerance));
  for (const char* solver : {"ordered", "newton"}) {
    const auto resolver = make_resolver(framework, {.solver = solver, .tolerance = tolerance});
    Positions x = molecule.positions();
    double longest = 0, least = 180, least_at_base = 180;
    for (int round = 0; round < 200; ++round) {
      const Positions before = x;
      Random random(3, RandomStream::perturbation, std::uint64_t(round));
      perturb(x, framework->fixed(), PerturbationKind::gaussian, 0.02, random);
      if (!resolver->resolve(x, {}).converged) {
        x = before;
        continue;
      }
      longest = std::max(longest, (x[7] - x[4]).norm());
      least = std::min(least, angle_at(x, 2, 4, 7));
      least_at_base = std::min(least_at_base, angle_at(x, 4, 7, 6));
    }
    EXPECT_LE(longest, nominal.tethers()[0].length) << solver;
    EXPECT_LE(longest, 0.25);
    EXPECT_GT(longest, 0.2);  // it does move
    EXPECT_GE(least, 110 - 0.2) << solver;
    EXPECT_LT(least, 150);
    EXPECT_GE(least_at_base, 90 - 0.2) << solver;
  }
}

TEST(Noncovalent, WithoutHydrogensTheHeavyAtomsAreHeld) {
  const Molecule whole = dimer();
  std::vector<Atom> atoms;
  Positions x;
  for (const int i : {0, 1, 2, 6, 7, 8}) {
    atoms.push_back(whole.atoms()[std::size_t(i)]);
    x.push_back(whole.positions()[std::size_t(i)]);
  }
  const Molecule bare(atoms,
                      {{0, 1, BondOrder::double_bond},
                       {0, 2, BondOrder::single},
                       {3, 4, BondOrder::double_bond},
                       {3, 5, BondOrder::single}},
                      x);
  const Framework framework = build_framework(bare, options_with());
  ASSERT_EQ(framework.held_bonds().size(), 1U);
  EXPECT_EQ(framework.held_bonds()[0].hydrogen, -1);
  ASSERT_EQ(framework.tethers().size(), 1U);
  EXPECT_EQ(std::pair(framework.tethers()[0].p, framework.tethers()[0].q), std::pair(2, 4));
  EXPECT_NEAR(framework.tethers()[0].length, (0.29 + 0.35) / 2, 1e-9);
  EXPECT_EQ(worst_violation(framework, bare.positions(), nullptr).relative, 0);
  ConstraintOptions without;
  without.place_hydrogens = false;
  EXPECT_TRUE(build_framework(bare, options_with(without)).tethers().empty());
}

TEST(Noncovalent, WatersBondIfTheyAreAskedTo) {
  const auto water = [](const Vec3& o) {
    return Positions{o, o + Vec3(0.096, 0, 0), o + Vec3(-0.024, 0.093, 0)};
  };
  Positions x = water(Vec3::Zero());
  for (const Vec3& p : water({0.28, 0, 0})) x.push_back(p);
  const Molecule molecule({{8, 0, 16}, {1, 0, 1}, {1, 0, 1}, {8, 0, 16}, {1, 0, 1}, {1, 0, 1}},
                          {{0, 1, BondOrder::single},
                           {0, 2, BondOrder::single},
                           {3, 4, BondOrder::single},
                           {3, 5, BondOrder::single}},
                          x);
  ConstraintOptions solvent;
  solvent.hydrogen_bond.weakest = -0.5 * kilojoule_per_kilocalorie;
  EXPECT_TRUE(build_framework(molecule, options_with(solvent)).tethers().empty());
  solvent.solvent_hydrogen_bonds = true;
  EXPECT_FALSE(build_framework(molecule, options_with(solvent)).tethers().empty());
}

TEST(Noncovalent, WhatAConformationDoesNotHaveIsNotHeld) {
  const Molecule molecule = dimer();
  ConstraintOptions constraints;
  Positions apart = molecule.positions();
  for (std::size_t i = 6; i < 12; ++i) apart[i] += Vec3(0.3, 0, 0);
  constraints.conformations = {apart};
  const Framework framework = build_framework(molecule, options_with(constraints));
  EXPECT_TRUE(framework.tethers().empty());
  EXPECT_TRUE(framework.held_bonds().empty());
  Positions near = molecule.positions();
  for (std::size_t i = 6; i < 12; ++i) near[i].z() += 0.01;
  constraints.conformations = {near};
  EXPECT_EQ(build_framework(molecule, options_with(constraints)).held_bonds().size(), 1U);
  constraints.conformations = {Positions(3, Vec3::Zero())};
  EXPECT_THROW(build_framework(molecule, options_with(constraints)), Error);
}

TEST(Noncovalent, AMetalHasBarsToItsDonorsAndNoneBetweenThem) {
  // zinc between four oxygens of formaldehydes, and a water's oxygen
  std::vector<Atom> atoms = {{30, 2, 65}};
  std::vector<Bond> bonds;
  Positions x = {Vec3::Zero()};
  for (const Vec3& corner : {Vec3(1, 1, 1), Vec3(-1, -1, 1), Vec3(-1, 1, -1), Vec3(1, -1, -1)}) {
    const Vec3 u = corner.normalized();
    bonds.push_back({int(atoms.size()), int(atoms.size()) + 1, BondOrder::double_bond});
    atoms.push_back({8, 0, 16});
    atoms.push_back({6, 0, 12});
    x.push_back(0.20 * u);
    x.push_back(0.322 * u);
  }
  atoms.push_back({8, 0, 16});
  x.push_back({0, 0, 0.22});
  const Molecule molecule(atoms, bonds, x);
  const Framework framework = build_framework(molecule, options_with());
  const auto metals = std::count_if(framework.bars().begin(), framework.bars().end(),
                                    [](const Bar& b) { return b.kind == BarKind::metal; });
  EXPECT_EQ(metals, 4);
  EXPECT_EQ(framework.bars().size(), 8U);
  EXPECT_TRUE(framework.bond_graph().links(0).empty());
  // the donors keep apart by the contact rule
  EXPECT_FALSE(framework.contact_rule().excluded(1, 3));
  EXPECT_TRUE(framework.contact_rule().excluded(0, 1));
  ConstraintOptions none;
  none.metals = false;
  EXPECT_EQ(build_framework(molecule, options_with(none)).bars().size(), 4U);
}

TEST(Noncovalent, RecordedBondsOfMetalsAreBarsWhateverTheirElementAndLength) {
  // zinc, and carbon further away than any rule reaches
  const Molecule molecule = loose_atoms({30, 6, 7}, {{0, 0, 0}, {0.29, 0, 0}, {0, 0.2, 0}});
  ConstraintOptions constraints;
  EXPECT_EQ(build_framework(molecule, options_with(constraints)).bars().size(), 1U);
  constraints.coordination = {{0, 1, 0, BarKind::metal}, {0, 2, 0, BarKind::metal}};
  const Framework framework = build_framework(molecule, options_with(constraints));
  ASSERT_EQ(framework.bars().size(), 2U);
  for (const Bar& bar : framework.bars()) EXPECT_EQ(bar.kind, BarKind::metal);
  EXPECT_EQ(framework.bars()[1].length, 0.29);
}

TEST(Noncovalent, BoundsOfAtomsThatBarsToFixedOnesPlaceAreLeftOut) {
  const Molecule molecule = dimer();
  ConstraintOptions constraints;
  for (int atom = 0; atom < 12; ++atom) constraints.fixed.push_back(atom);
  // one atom that moves, but that bars hold to all others of its planar molecule
  int tried = 0;
  for (int free = 6; free < 12; ++free) {
    ConstraintOptions one = constraints;
    one.fixed.erase(one.fixed.begin() + free);
    const Framework framework = build_framework(molecule, options_with(one));
    int held = 0;
    for (const Bar& bar : framework.bars()) held += bar.p == free || bar.q == free;
    if (held >= 3) {
      ++tried;
      EXPECT_EQ(framework.tethers().size(), 0U) << free;
      EXPECT_EQ(framework.contacts().size(), 0U) << free;
    }
  }
  EXPECT_GT(tried, 0);
}

TEST(Noncovalent, TheUsersOwnAreTakenAsTheyAre) {
  const Molecule molecule = loose_atoms({6, 6, 6, 6}, {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}});
  ConstraintOptions constraints;
  constraints.bars = {{0, 1, 0, BarKind::user}, {1, 2, 0.9, BarKind::user}};
  constraints.tethers = {{0, 3, 2.5}, {3, 0, 2.7}};
  constraints.contacts = {{0, 2, 1.5}, {0, 1, 0.5}};
  constraints.fixed = {3};
  const Framework framework = build_framework(molecule, options_with(constraints));
  ASSERT_EQ(framework.bars().size(), 2U);
  EXPECT_EQ(framework.bars()[0].length, 1);
  EXPECT_EQ(framework.bars()[1].length, 0.9);
  EXPECT_EQ(framework.bars()[1].kind, BarKind::user);
  ASSERT_EQ(framework.tethers().size(), 1U);
  EXPECT_EQ(framework.tethers()[0].length, 2.5);
  ASSERT_EQ(framework.contacts().size(), 1U);  // a bar says all of its pair
  EXPECT_EQ(framework.fixed(), (std::vector<std::uint8_t>{0, 0, 0, 1}));
}

TEST(Noncovalent, BoundsBetweenFixedAtomsAreLeftOutButTheUsersOwn) {
  const Molecule molecule = dimer();
  ConstraintOptions constraints;
  const std::size_t free_tethers =
      build_framework(molecule, options_with(constraints)).tethers().size();
  ASSERT_GT(free_tethers, 0U);
  for (int atom = 0; atom < 12; ++atom) constraints.fixed.push_back(atom);
  EXPECT_EQ(build_framework(molecule, options_with(constraints)).tethers().size(), 0U);
  constraints.tethers = {{0, 8, 2.0}};
  const Framework framework = build_framework(molecule, options_with(constraints));
  ASSERT_EQ(framework.tethers().size(), 1U);
  EXPECT_EQ(framework.tethers()[0].kind, TetherKind::user);
  // one that moves has its bounds
  constraints.tethers.clear();
  constraints.fixed.erase(constraints.fixed.begin() + 6, constraints.fixed.end());
  EXPECT_EQ(build_framework(molecule, options_with(constraints)).tethers().size(), free_tethers);
}

TEST(Noncovalent, WhatMakesNoSenseIsRefused) {
  const Molecule molecule = methylacetamide();
  const auto refuses = [&](const auto& change) {
    ConstraintOptions constraints;
    change(constraints);
    EXPECT_THROW(build_framework(molecule, options_with(constraints)), Error);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  refuses([&](ConstraintOptions& c) { c.hydrogen_bond.weakest = nan; });
  refuses([&](ConstraintOptions& c) { c.hydrogen_bond_room = 1.5; });
  refuses([&](ConstraintOptions& c) { c.metal_slack = nan; });
  refuses([&](ConstraintOptions& c) { c.eclipsed_degree = 90; });
  refuses([&](ConstraintOptions& c) { c.tethers = {{0, 99, 1}}; });
  refuses([&](ConstraintOptions& c) { c.tethers = {{0, 0, 1}}; });
  refuses([&](ConstraintOptions& c) { c.tethers = {{0, 5, nan}}; });
  refuses([&](ConstraintOptions& c) { c.contacts = {{0, 5, 0}}; });
  refuses([&](ConstraintOptions& c) { c.bars = {{0, 1, 0.2}}; });  // a bond has its length
  refuses([&](ConstraintOptions& c) { c.coordination = {{0, 99, 0}}; });
  refuses([&](ConstraintOptions& c) { c.fixed = {-1}; });
}

TEST(Noncovalent, TheWorstIsNamedByItsKind) {
  const Molecule molecule = dimer();
  const Framework framework = build_framework(molecule, options_with());
  Positions x = molecule.positions();
  for (std::size_t i = 6; i < 12; ++i) x[i] += Vec3(0.5, 0, 0);
  EXPECT_EQ(
      worst_violation(framework, x, nullptr).what.rfind("hydrogen bond joint 4 - joint 7 is ", 0),
      0U);
}

TEST(Noncovalent, TightenedBoundsAreKeptWithinTheToleranceOfTheOthers) {
  const Framework framework = build_framework(dimer(), options_with());
  for (const Tolerance& tolerance : {Tolerance(0.01), Tolerance::nanometers(0.002)}) {
    const Framework inner = tightened(framework, tolerance);
    for (std::size_t k = 0; k < framework.tethers().size(); ++k) {
      const double length = inner.tethers()[k].length;
      EXPECT_NEAR(length + tolerance.slack(length), framework.tethers()[k].length, 1e-12);
    }
    for (std::size_t k = 0; k < framework.contacts().size(); ++k) {
      const double length = inner.contacts()[k].length;
      EXPECT_NEAR(length - tolerance.slack(length), framework.contacts()[k].length, 1e-12);
    }
  }
}

TEST(Noncovalent, GeometryTellsByHowMuchBoundsAreExceeded) {
  const Molecule molecule = dimer();
  const auto framework =
      std::make_shared<const Framework>(build_framework(molecule, options_with()));
  GeometryCheck check(framework, molecule.positions(), {}, 0.01);
  check.add(molecule.positions());
  EXPECT_EQ(check.report().tether_worst[std::size_t(TetherKind::hydrogen_bond)], 0);
  EXPECT_EQ(check.report().tolerance_violations, 0);
  Positions x = molecule.positions();
  for (std::size_t i = 6; i < 12; ++i) x[i] += 0.2 * (x[4] - x[2]).normalized();
  check.add(x);
  EXPECT_NEAR(check.report().tether_worst[std::size_t(TetherKind::hydrogen_bond)],
              (x[7] - x[4]).norm() - framework->tethers()[0].length, 1e-12);
  EXPECT_GE(check.report().tolerance_violations, 1);
}

}  // namespace
}  // namespace ragdoll
