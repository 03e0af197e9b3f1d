// Tests for core/src/backbone_bounds.cpp, staggered_bounds.cpp and ramachandran.cpp.

#include "torsion_bounds.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>  // AngleAxisd
#include <algorithm>       // count_if
#include <cmath>           // abs, remainder
#include <memory>
#include <numbers>  // pi

#include "examples.h"
#include "molecules.h"
#include "peptides.h"
#include "ragdoll/break.h"            // perturb
#include "ragdoll/build_framework.h"  // build_framework
#include "ragdoll/random.h"           // Random
#include "ragdoll/resolver.h"         // worst_violation

namespace ragdoll {
namespace {

using namespace examples;

constexpr PhiPsi helix = {-63, -42}, strand = {-120, 135}, left = {57, 40}, bridge = {-90, 60};

FrameworkOptions torsions_alone(TorsionRegion region = TorsionRegion::basin) {
  ConstraintOptions constraints;
  constraints.hydrogen_bonds = constraints.hydrophobic = constraints.stacking = false;
  constraints.torsion_region = region;
  FrameworkOptions options;
  options.contacts = false;
  options.constraints = constraints;
  return options;
}

Framework framework_of(const Molecule& molecule, TorsionRegion region = TorsionRegion::basin) {
  return build_framework(molecule, torsions_alone(region));
}

/// Whether a framework allows its one alanine these torsions.
bool allows(const Framework& framework, PhiPsi torsions, bool mirrored = false) {
  const Molecule there = alanines({torsions}, mirrored);
  return worst_violation(framework, there.positions(), nullptr).relative < 1e-9;
}

int backbone_bounds(const Framework& framework) {
  return int(std::count_if(framework.tethers().begin(), framework.tethers().end(),
                           [](const Tether& t) { return t.kind == TetherKind::backbone; }) +
             std::count_if(framework.contacts().begin(), framework.contacts().end(),
                           [](const Contact& c) { return c.kind == ContactKind::backbone; }));
}

TEST(BackboneBounds, AResidueStaysInItsBasin) {
  for (const PhiPsi start : {helix, strand, left}) {
    const Framework framework = framework_of(alanines({start}));
    EXPECT_GE(backbone_bounds(framework), 4);
    for (const PhiPsi end : {helix, strand, left, PhiPsi{60, -120}, PhiPsi{0, 0}, PhiPsi{120, 60}})
      EXPECT_EQ(allows(framework, end), end.phi == start.phi)
          << start.phi << " " << start.psi << " to " << end.phi << " " << end.psi;
  }
}

TEST(BackboneBounds, TheBasinIsAsWideAsTheMap) {
  const Framework in_helix = framework_of(alanines({helix}));
  for (const PhiPsi torsions : {PhiPsi{-50, -50}, PhiPsi{-90, -5}, PhiPsi{-115, 10}})
    EXPECT_TRUE(allows(in_helix, torsions)) << torsions.phi;
  for (const PhiPsi torsions : {PhiPsi{-150, -50}, PhiPsi{-80, 60}, PhiPsi{-60, -90}})
    EXPECT_FALSE(allows(in_helix, torsions)) << torsions.phi;
  const Framework in_strand = framework_of(alanines({strand}));
  for (const PhiPsi torsions : {PhiPsi{-65, 145}, PhiPsi{-155, 160}, PhiPsi{-85, 110}})
    EXPECT_TRUE(allows(in_strand, torsions)) << torsions.phi;
  for (const PhiPsi torsions : {PhiPsi{-30, 135}, PhiPsi{-120, 60}, PhiPsi{-120, -140}})
    EXPECT_FALSE(allows(in_strand, torsions)) << torsions.phi;
}

TEST(BackboneBounds, JoinedBasinsLetAResidueCrossTheBridge) {
  EXPECT_FALSE(allows(framework_of(alanines({helix})), bridge));
  for (const PhiPsi start : {helix, strand}) {
    const Framework joined = framework_of(alanines({start}), TorsionRegion::joined);
    for (const PhiPsi end : {helix, bridge, strand}) EXPECT_TRUE(allows(joined, end)) << end.psi;
    for (const PhiPsi end : {left, PhiPsi{60, -120}, PhiPsi{-90, -110}})
      EXPECT_FALSE(allows(joined, end)) << end.psi;
  }
}

TEST(BackboneBounds, WhatStartsElsewhereKeepsThatAndMayComeIn) {
  for (const PhiPsi odd : {PhiPsi{60, -120}, PhiPsi{-60, -100}, PhiPsi{150, 170}, PhiPsi{0, 90}}) {
    const Molecule molecule = alanines({odd});
    EXPECT_EQ(worst_violation(framework_of(molecule), molecule.positions(), nullptr).relative, 0)
        << odd.phi;
  }
  // a little beyond the edge, the way in is open
  const Framework framework = framework_of(alanines({{-75, -75}}));
  for (double psi = -75; psi < -40; psi += 5) EXPECT_TRUE(allows(framework, {-75, psi})) << psi;
}

TEST(BackboneBounds, MirrorImagesHaveTheMirroredMap) {
  const Framework framework = framework_of(alanines({helix}, true));
  EXPECT_TRUE(allows(framework, helix, true));
  EXPECT_TRUE(allows(framework, {-100, -20}, true));
  EXPECT_FALSE(allows(framework, strand, true));
  EXPECT_FALSE(allows(framework, left, true));
}

TEST(BackboneBounds, BothEndsOfAPathAreAllowed) {
  const Molecule start = alanines({helix}), end = alanines({strand});
  FrameworkOptions options = torsions_alone();
  options.constraints->conformations = {end.positions()};
  const Framework framework = build_framework(start, options);
  for (const PhiPsi torsions : {helix, bridge, strand}) EXPECT_TRUE(allows(framework, torsions));
  EXPECT_FALSE(allows(framework, left));
}

TEST(BackboneBounds, TheyHoldWhileTheChainIsShaken) {
  const Molecule molecule = alanines({helix, helix, strand, left, strand});
  const auto framework = std::make_shared<const Framework>(framework_of(molecule));
  for (const char* solver : {"ordered", "newton"}) {
    const auto resolver =
        make_resolver(framework, {.solver = solver, .tolerance = 1e-3, .max_iterations = 20000});
    Positions x = molecule.positions();
    int resolved = 0;
    for (int round = 0; round < 60; ++round) {
      const Positions before = x;
      Random random(5, RandomStream::perturbation, std::uint64_t(round));
      perturb(x, framework->fixed(), PerturbationKind::gaussian, 0.01, random);
      if (!resolver->resolve(x, {}).converged || inverted_centres(*framework, x) > 0) {
        x = before;
        continue;
      }
      ++resolved;
      const auto near = [&](int alanine, PhiPsi middle, double phi, double psi) {
        const PhiPsi now = torsions_of(x, alanine);
        EXPECT_LE(std::abs(std::remainder(now.phi - middle.phi, 360)), phi) << alanine;
        EXPECT_LE(std::abs(std::remainder(now.psi - middle.psi, 360)), psi) << alanine;
      };
      near(0, {-82, -20}, 50, 55);
      near(1, {-82, -20}, 50, 55);
      near(2, {-105, 140}, 75, 60);
      near(3, {66, 20}, 40, 55);
      near(4, {-105, 140}, 75, 60);
    }
    EXPECT_GT(resolved, 30) << solver;
  }
}

TEST(BackboneBounds, ResiduesAreFoundByTheirBonds) {
  const Molecule molecule = alanines({helix, strand});
  const auto residues = backbone_residues(molecule, PlanarUnits(molecule));
  ASSERT_EQ(residues.size(), 2U);
  EXPECT_EQ(residues[0].alpha_before, 0);
  EXPECT_EQ(residues[0].carbon_before, 1);
  EXPECT_EQ(residues[0].nitrogen, 3);
  EXPECT_EQ(residues[0].beta, 7);
  EXPECT_EQ(residues[0].nitrogen_after, 8);
  EXPECT_EQ(residues[1].alpha_before, 4);
  EXPECT_EQ(residues[1].alpha_after, 14);
  EXPECT_FALSE(residues[0].is_proline);
  EXPECT_TRUE(backbone_residues(heptane(), PlanarUnits(heptane())).empty());
  // without its beta carbon it is a glycine
  std::vector<Atom> atoms = molecule.atoms();
  atoms[7].element = 1;
  const Molecule glycine(atoms, molecule.bonds(), molecule.positions());
  EXPECT_EQ(backbone_residues(glycine, PlanarUnits(glycine)).size(), 1U);
}

TEST(StaggeredBounds, HeavyAtomsStayOffTheEclipsedPosition) {
  const Molecule molecule = heptane();
  const Framework framework = framework_of(molecule);
  const auto bound = std::find_if(
      framework.contacts().begin(), framework.contacts().end(),
      [](const Contact& c) { return c.kind == ContactKind::side_chain && c.p == 1 && c.q == 4; });
  ASSERT_NE(bound, framework.contacts().end());
  // carbons 1-2-3-4: turn all from 4 on
  const auto distance_at = [&](double torsion) {
    const Positions& x = molecule.positions();
    const Vec3 ab = x[2] - x[1], bc = x[3] - x[2], n = bc.cross(x[4] - x[3]);
    const double now = std::atan2(bc.norm() * ab.dot(n), ab.cross(bc).dot(n));
    const Eigen::AngleAxisd turn(torsion * std::numbers::pi / 180 - now, bc.normalized());
    return (x[3] + turn * (x[4] - x[3]) - x[1]).norm();
  };
  EXPECT_NEAR(bound->length, distance_at(30), 1e-9);
  EXPECT_NEAR(bound->length, distance_at(-30), 1e-9);
  EXPECT_LT(distance_at(20), bound->length);
  EXPECT_GT(distance_at(60), bound->length);
}

TEST(StaggeredBounds, FlatBondsAndSmallRingsHaveNone) {
  for (const Molecule& molecule :
       {benzene(), methylacetamide(), cyclopentane_ring(), acetylene()}) {
    const Framework framework = framework_of(molecule);
    EXPECT_TRUE(framework.contacts().empty()) << molecule.name(0);
    EXPECT_TRUE(framework.tethers().empty());
  }
}

}  // namespace
}  // namespace ragdoll
