// Tests for core/src/build_framework.cpp and chemistry_rules.cpp.

#include "ragdoll/build_framework.h"

#include <gtest/gtest.h>

#include <algorithm>  // sort, count_if, find_if
#include <array>
#include <cmath>  // isfinite, atan2, abs, remainder
#include <limits>
#include <numbers>  // pi

#include "examples.h"
#include "molecules.h"
#include "ragdoll/break.h"     // perturb
#include "ragdoll/resolver.h"  // make_resolver

namespace ragdoll {
namespace {

using namespace examples;

using Pair = std::pair<int, int>;

constexpr double degree = 180 / std::numbers::pi;

/// The bars of a kind as sorted pairs.
std::vector<Pair> bars_of(const Framework& framework, BarKind kind) {
  std::vector<Pair> pairs;
  for (const Bar& bar : framework.bars())
    if (bar.kind == kind) pairs.push_back(std::minmax(bar.p, bar.q));
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

int volumes_of(const Framework& framework, VolumeKind kind) {
  return int(std::count_if(framework.volumes().begin(), framework.volumes().end(),
                           [kind](const Volume& v) { return v.kind == kind; }));
}

double volume_at(const Volume& v, const Positions& x) {
  return signed_volume(x[std::size_t(v.a)], x[std::size_t(v.b)], x[std::size_t(v.c)],
                       x[std::size_t(v.d)]);
}

double torsion_degree(const Positions& x, int a, int b, int c, int d) {
  const Vec3 ab = x[std::size_t(b)] - x[std::size_t(a)];
  const Vec3 bc = x[std::size_t(c)] - x[std::size_t(b)];
  const Vec3 cd = x[std::size_t(d)] - x[std::size_t(c)];
  const Vec3 m = ab.cross(bc), n = bc.cross(cd);
  return std::atan2(m.cross(n).dot(bc.normalized()), m.dot(n)) * degree;
}

/// Perturbs from the input again and again, and looks at what is resolved. @return how often it was
template <class Look>
int perturb_and_resolve(const Molecule& molecule, const FrameworkOptions& options, double size,
                        int rounds, Look look) {
  const auto framework = std::make_shared<const Framework>(build_framework(molecule, options));
  const auto resolver = make_resolver(framework, {.solver = "ordered", .max_iterations = 3000});
  int converged = 0;
  for (int round = 0; round < rounds; ++round) {
    Random random(round % 7, RandomStream::perturbation, std::uint64_t(round));
    Positions x = molecule.positions();
    perturb(x, framework->fixed(), PerturbationKind::gaussian, size, random);
    if (!resolver->resolve(x, {}).converged) continue;
    ++converged;
    look(*framework, x);
  }
  return converged;
}

// === Bars

TEST(BuildFramework, MethaneHasItsBondsAnglesAndOneCentre) {
  const Framework methane = build_framework(methane_like());
  EXPECT_EQ(bars_of(methane, BarKind::bond), (std::vector<Pair>{{0, 1}, {0, 2}, {0, 3}, {0, 4}}));
  EXPECT_EQ(bars_of(methane, BarKind::angle),
            (std::vector<Pair>{{1, 2}, {1, 3}, {1, 4}, {2, 3}, {2, 4}, {3, 4}}));
  EXPECT_EQ(bars_of(methane, BarKind::planar), std::vector<Pair>{});
  EXPECT_EQ(methane.volumes().size(), 1U);
  EXPECT_EQ(methane.chirality_count(), 1);
  EXPECT_EQ(methane.joint_count(), 5);
  EXPECT_EQ(methane.masses()[0], 12.011);
  EXPECT_NEAR(methane.bars()[0].length, 0.109, 1e-12);
  EXPECT_NEAR(methane.bars()[4].length, 0.109 * std::sqrt(8.0 / 3), 1e-12);
}

TEST(BuildFramework, EthaneTurnsAboutItsBond) {
  const Framework framework = build_framework(ethane());
  EXPECT_EQ(bars_of(framework, BarKind::bond).size(), 7U);
  // 6 pairs about each carbon
  EXPECT_EQ(bars_of(framework, BarKind::angle).size(), 12U);
  EXPECT_EQ(bars_of(framework, BarKind::planar), std::vector<Pair>{});
  EXPECT_EQ(framework.chirality_count(), 2);
  EXPECT_EQ(volumes_of(framework, VolumeKind::planarity), 0);

  // turned by a third of a circle about its axis nothing is broken
  Positions x = ethane().positions();
  const Eigen::AngleAxisd turn(2, Vec3::UnitX());
  for (std::size_t k = 5; k < 8; ++k) x[k] = turn * x[k];
  EXPECT_LT(worst_violation(framework, x, nullptr).relative, 1e-12);
}

TEST(BuildFramework, InputItselfIsWhole) {
  for (const Molecule& molecule :
       {methane_like(), methane_like(1, 9, 17, 35), ethane(), ammonia(), formamide(),
        methylacetamide(), methylacetamide(165), methylacetamide(0), benzene(), acetylene(),
        allene(), cyclopentane_ring(), heptane()}) {
    const Framework framework = build_framework(molecule);
    const Violation worst = worst_violation(framework, molecule.positions(), nullptr);
    EXPECT_LT(worst.relative, 1e-12) << worst.what;
    EXPECT_EQ(inverted_centres(framework, molecule.positions()), 0);
  }
}

TEST(BuildFramework, BarsHaveTheirInputLengthsAndComeOnce) {
  for (const Molecule& molecule : {benzene(), cyclopentane_ring(), methylacetamide()}) {
    const Framework framework = build_framework(molecule);
    std::vector<Pair> pairs;
    for (const Bar& bar : framework.bars()) {
      pairs.push_back(std::minmax(bar.p, bar.q));
      EXPECT_EQ(bar.length, (molecule.positions()[std::size_t(bar.q)] -
                             molecule.positions()[std::size_t(bar.p)])
                                .norm());
    }
    std::sort(pairs.begin(), pairs.end());
    EXPECT_EQ(std::adjacent_find(pairs.begin(), pairs.end()), pairs.end());
  }
}

// === Planar units

TEST(BuildFramework, FormamideIsPlanar) {
  const Framework framework = build_framework(formamide());
  EXPECT_EQ(bars_of(framework, BarKind::bond).size(), 5U);
  EXPECT_EQ(bars_of(framework, BarKind::angle).size(), 6U);
  // O and H of the carbon with both H of the nitrogen
  EXPECT_EQ(bars_of(framework, BarKind::planar),
            (std::vector<Pair>{{1, 4}, {1, 5}, {3, 4}, {3, 5}}));
  // one torsion, C and N trigonal
  EXPECT_EQ(volumes_of(framework, VolumeKind::planarity), 3);
  EXPECT_EQ(framework.chirality_count(), 0);
}

TEST(BuildFramework, PeptideBondHoldsItsTorsion) {
  const Framework framework = build_framework(methylacetamide());
  EXPECT_EQ(bars_of(framework, BarKind::planar),
            (std::vector<Pair>{{1, 4}, {1, 5}, {3, 4}, {3, 5}}));
  EXPECT_EQ(framework.chirality_count(), 2);
  ASSERT_EQ(volumes_of(framework, VolumeKind::planarity), 3);
  const auto omega =
      std::find_if(framework.volumes().begin(), framework.volumes().end(), [](const Volume& v) {
        return Pair(std::minmax(v.a, v.d)) == Pair(3, 4) &&
               Pair(std::minmax(v.b, v.c)) == Pair(0, 2);
      });
  ASSERT_NE(omega, framework.volumes().end());
  // K sin(170) and K sin(190)
  EXPECT_NEAR(omega->upper / omega->scale, std::sin(10 / degree), 1e-9);
  EXPECT_NEAR(omega->lower / omega->scale, -std::sin(10 / degree), 1e-9);
}

TEST(BuildFramework, TorsionMayTurnByThePlanarityAndNoFurther) {
  // the rotation about C-N, applied to the nitrogen's side, one degree inside and outside
  for (const double start : {180.0, 170.0, 0.0, -20.0}) {
    FrameworkOptions options;
    options.contacts = false;
    const Framework framework = build_framework(methylacetamide(start), options);
    for (const double turn : {-11.0, -9.0, 9.0, 11.0}) {
      const Positions x = methylacetamide(start + turn).positions();
      double worst = 0;
      for (const Volume& v : framework.volumes()) {
        const double value = volume_at(v, x);
        worst = std::max({worst, (v.lower - value) / v.scale, (value - v.upper) / v.scale});
      }
      if (std::abs(turn) < 10)
        EXPECT_LE(worst, 1e-9) << start << " turned by " << turn;
      else
        EXPECT_GT(worst, 1e-3) << start << " turned by " << turn;
    }
  }
}

TEST(BuildFramework, OmegaStaysWithinThePlanarity) {
  for (const double start : {180.0, 0.0}) {
    const Molecule molecule = methylacetamide(start);
    double largest = 0;
    const int converged =
        perturb_and_resolve(molecule, {}, 0.02, 200, [&](const Framework&, const Positions& x) {
          const double change = torsion_degree(x, 3, 0, 2, 4) - start;
          largest = std::max(largest, std::abs(std::remainder(change, 360.0)));
        });
    EXPECT_GT(converged, 150);
    EXPECT_LE(largest, 10.5);
    EXPECT_GT(largest, 1);  // it does move
  }
}

TEST(BuildFramework, NitrogenAndCarbonOfAnAmideStayFlat) {
  const Molecule molecule = formamide();
  const int converged =
      perturb_and_resolve(molecule, {}, 0.02, 100, [](const Framework&, const Positions& x) {
        for (const auto& [a, b, c, d] : {std::array{0, 1, 2, 3}, std::array{2, 0, 4, 5}}) {
          // height of the centre's neighbour d over the plane of the others
          const Vec3 u = x[std::size_t(b)] - x[std::size_t(a)];
          const Vec3 v = x[std::size_t(c)] - x[std::size_t(a)];
          const Vec3 w = x[std::size_t(d)] - x[std::size_t(a)];
          const double sine = u.cross(v).normalized().dot(w.normalized());
          EXPECT_LE(std::abs(std::asin(sine)) * degree, 10.5);
        }
      });
  EXPECT_GT(converged, 80);
}

TEST(BuildFramework, BenzeneIsRigidAndFlat) {
  const Framework framework = build_framework(benzene());
  // within the ring: 6 bonds, 6 angle bars, 3 across; and the hydrogens'
  EXPECT_EQ(bars_of(framework, BarKind::bond).size(), 12U);
  EXPECT_EQ(bars_of(framework, BarKind::angle).size(), 18U);
  // C-C-C-C 3, H-C-C-C 12, H-C-C-H 6
  EXPECT_EQ(bars_of(framework, BarKind::planar).size(), 3U + 12U + 6U);
  EXPECT_EQ(framework.chirality_count(), 0);
  // six torsions and six trigonal carbons
  EXPECT_EQ(volumes_of(framework, VolumeKind::planarity), 12);

  const int converged =
      perturb_and_resolve(benzene(), {}, 0.01, 50, [](const Framework&, const Positions& x) {
        for (int k = 0; k < 6; ++k)
          EXPECT_LE(std::abs(torsion_degree(x, k, (k + 1) % 6, (k + 2) % 6, (k + 3) % 6)), 11);
      });
  EXPECT_GT(converged, 40);
}

TEST(BuildFramework, AminesAndEstersTurn) {
  // ammonia is pyramidal: one centre, no planar bar
  const Framework pyramid = build_framework(ammonia());
  EXPECT_EQ(pyramid.chirality_count(), 1);
  EXPECT_EQ(bars_of(pyramid, BarKind::planar), std::vector<Pair>{});
  // the same amide spelled with oxygen in place of nitrogen turns: an ester
  Molecule amide = formamide();
  std::vector<Atom> atoms = amide.atoms();
  atoms[2].element = 8;
  const Framework ester = build_framework(Molecule(atoms, amide.bonds(), amide.positions()));
  EXPECT_EQ(bars_of(ester, BarKind::planar), std::vector<Pair>{});
}

// === Cis and trans

TEST(BuildFramework, PlanarBondsKnowTheirSide) {
  for (const double omega : {180., 165., 0., 20.}) {
    const Framework framework = build_framework(methylacetamide(omega));
    ASSERT_EQ(framework.planar_torsions().size(), 1U);
    const PlanarTorsion& t = framework.planar_torsions()[0];
    EXPECT_EQ(std::minmax(t.b, t.c), std::minmax(0, 2));
    // C 3 and O 1 lie across each other on C 0, C 4 and H 5 on N 2
    const bool like_carbons = (t.a == 3 || t.d == 3) == (t.a == 4 || t.d == 4);
    EXPECT_EQ(t.cis, (omega < 90) == like_carbons) << omega;
  }
}

TEST(BuildFramework, GoingOverFromTransToCisIsAnInversion) {
  const Framework trans = build_framework(methylacetamide(180));
  const Framework cis = build_framework(methylacetamide(0));
  for (const double omega : {180., 160., 100.}) {
    EXPECT_EQ(inverted_centres(trans, methylacetamide(omega).positions()), 0);
    EXPECT_EQ(inverted_centres(cis, methylacetamide(omega).positions()), 1);
  }
  for (const double omega : {0., 20., 80.}) {
    EXPECT_EQ(inverted_centres(trans, methylacetamide(omega).positions()), 1);
    EXPECT_EQ(inverted_centres(cis, methylacetamide(omega).positions()), 0);
  }
}

TEST(BuildFramework, ABondTurnedByAQuarterHasNoSide) {
  EXPECT_TRUE(build_framework(methylacetamide(90)).planar_torsions().empty());
}

TEST(BuildFramework, EachBondOfARingHasOneTorsion) {
  EXPECT_EQ(build_framework(benzene()).planar_torsions().size(), 6U);
}

// === Linear units

TEST(BuildFramework, LinearUnitsHaveNoVolumesButForTheTwistOfAllene) {
  const Framework linear = build_framework(acetylene());
  EXPECT_TRUE(linear.volumes().empty());
  EXPECT_EQ(bars_of(linear, BarKind::bond).size(), 3U);
  EXPECT_EQ(bars_of(linear, BarKind::angle), (std::vector<Pair>{{0, 3}, {1, 2}}));

  // the two CH2 of allene are flat, each in its own plane, one across the other
  const Framework cumulated = build_framework(allene());
  EXPECT_EQ(cumulated.volumes().size(), 3U);
  for (const Volume& v : cumulated.volumes()) EXPECT_NE(v.a, 1);
  EXPECT_EQ(cumulated.chirality_count(), 1);
  EXPECT_EQ(bars_of(cumulated, BarKind::planar), std::vector<Pair>{});
}

TEST(BuildFramework, TheHandOfAlleneIsItsTwist) {
  const Molecule molecule = allene();
  const Framework framework = build_framework(molecule);
  Positions mirrored = molecule.positions();
  std::swap(mirrored[5], mirrored[6]);
  EXPECT_EQ(inverted_centres(framework, mirrored), 1);
  EXPECT_GT(worst_violation(framework, mirrored, nullptr).relative, 1);
}

TEST(BuildFramework, LinearUnitsAreResolved) {
  for (const Molecule& molecule : {acetylene(), allene()})
    EXPECT_GT(
        perturb_and_resolve(molecule, {}, 0.01, 50, [](const Framework&, const Positions&) {}), 40);
}

// === Chirality

TEST(BuildFramework, ACentreThatLeavesItsNeighboursThroughAFaceIsInverted) {
  const Molecule molecule = methane_like(1, 9, 17, 35);
  const Framework framework = build_framework(molecule);
  EXPECT_EQ(framework.centres(), std::vector<int>{0});
  // the neighbours' volume does not change, but seen from the centre three of them turn the other
  // way
  for (std::size_t k = 1; k <= 4; ++k) {
    Positions x = molecule.positions();
    const Vec3 away = x[0] - x[k];
    x[0] += 0.3 * away;
    EXPECT_EQ(inverted_centres(framework, x), 0);
    x[0] += 0.05 * away;
    EXPECT_EQ(inverted_centres(framework, x), 1);
  }
}

TEST(BuildFramework, OnlyCentresWithinFourNeighboursAreKnownAsSuch) {
  for (const Molecule& molecule : {heptane(), cyclopentane_ring(), ammonia(), methylacetamide()}) {
    const Framework framework = build_framework(molecule);
    for (std::size_t k = 0; k < framework.volumes().size(); ++k) {
      const Volume& v = framework.volumes()[k];
      const int centre = framework.centres()[k];
      const auto is_neighbour = [&](int joint, int of) {
        return std::ranges::any_of(molecule.neighbours(of),
                                   [&](const auto& n) { return n.atom == joint; });
      };
      const bool four = v.kind == VolumeKind::chirality && !is_neighbour(v.b, v.a);
      EXPECT_EQ(centre >= 0, four);
      if (!four) continue;
      for (const int joint : {v.a, v.b, v.c, v.d}) EXPECT_TRUE(is_neighbour(joint, centre));
    }
  }
}

TEST(BuildFramework, CentreKeepsItsSignAndHalfItsVolume) {
  const Molecule molecule = methane_like(1, 9, 17, 35);
  const Framework framework = build_framework(molecule);
  ASSERT_EQ(framework.volumes().size(), 1U);
  const Volume& v = framework.volumes()[0];
  const double volume = volume_at(v, molecule.positions());
  EXPECT_NEAR(v.scale, std::abs(volume), 1e-15);
  EXPECT_NEAR(volume > 0 ? v.lower : v.upper, volume / 2, 1e-15);
  EXPECT_TRUE(std::isinf(volume > 0 ? v.upper : v.lower));

  Positions mirrored = molecule.positions();
  for (Vec3& point : mirrored) point[0] = -point[0];
  EXPECT_EQ(inverted_centres(framework, mirrored), 1);
  // its bars are all whole: the volume alone tells
  EXPECT_NEAR(worst_violation(framework, mirrored, nullptr).relative, 1.5, 1e-9);
}

TEST(BuildFramework, MirroredInputHasTheOtherSign) {
  const Molecule molecule = methane_like(1, 9, 17, 35);
  Positions mirrored = molecule.positions();
  for (Vec3& point : mirrored) point[0] = -point[0];
  const Framework framework =
      build_framework(Molecule(molecule.atoms(), molecule.bonds(), mirrored));
  EXPECT_EQ(inverted_centres(framework, mirrored), 0);
  EXPECT_EQ(inverted_centres(framework, molecule.positions()), 1);
}

TEST(BuildFramework, ResolvedCentresAreNeverInverted) {
  // moves as large as bonds: many are not resolved, but none is accepted inverted
  for (const Molecule& molecule : {methane_like(1, 9, 17, 35), ethane(), ammonia(), heptane()})
    for (const double size : {0.02, 0.05, 0.15}) {
      const int converged = perturb_and_resolve(
          molecule, {}, size, 100,
          [](const Framework& f, const Positions& x) { EXPECT_EQ(inverted_centres(f, x), 0); });
      if (size < 0.03) {
        EXPECT_GT(converged, 80);
      }
    }
}

TEST(BuildFramework, MirroredMoleculeIsNeverAcceptedAsItIs) {
  for (const Molecule& molecule : {methane_like(1, 9, 17, 35), heptane()}) {
    const auto framework = std::make_shared<const Framework>(build_framework(molecule));
    Positions x = molecule.positions();
    for (Vec3& point : x) point[1] = -point[1];
    const ResolveReport report =
        make_resolver(framework, {.solver = "ordered", .max_iterations = 2000})->resolve(x, {});
    EXPECT_GT(report.iterations, 0);
    if (report.converged) {
      EXPECT_EQ(inverted_centres(*framework, x), 0);
    }
  }
}

TEST(BuildFramework, MetalsAreLeftToTheirBarsAndDonorsKeepTheShapeOfTheirOwnBonds) {
  const Molecule methane = methane_like();
  std::vector<Bond> bonds = methane.bonds();
  bonds[0].order = BondOrder::dative;
  std::vector<Atom> atoms = methane.atoms();
  const Framework donor = build_framework(Molecule(atoms, bonds, methane.positions()));
  ASSERT_EQ(donor.volumes().size(), 1U);
  // of the centre and the three that are bonded to it
  const Volume& v = donor.volumes()[0];
  for (const int joint : {v.a, v.b, v.c, v.d}) EXPECT_NE(joint, bonds[0].b);
  EXPECT_EQ(v.a, bonds[0].a);
  atoms[std::size_t(bonds[0].a)].element = 30;
  EXPECT_TRUE(build_framework(Molecule(atoms, bonds, methane.positions())).volumes().empty());
}

// === Small rings

TEST(BuildFramework, FiveRingKeepsTheSignOfItsPucker) {
  const Molecule molecule = cyclopentane_ring();
  const Framework framework = build_framework(molecule);
  EXPECT_EQ(framework.bars().size(), 10U);
  EXPECT_FALSE(framework.volumes().empty());
  EXPECT_EQ(framework.chirality_count(), 0);

  const double start = torsion_degree(molecule.positions(), 4, 0, 1, 2);
  ASSERT_GT(std::abs(start), 20);
  const int converged =
      perturb_and_resolve(molecule, {}, 0.05, 200, [&](const Framework&, const Positions& x) {
        EXPECT_GT(torsion_degree(x, 4, 0, 1, 2) * start, 0);
      });
  EXPECT_GT(converged, 100);

  // without the volumes it would be mirrored now and then
  FrameworkParts bars_only = framework.parts();
  bars_only.volumes.clear();
  const auto resolver =
      make_resolver(framework_of(bars_only), {.solver = "ordered", .max_iterations = 3000});
  int mirrored = 0;
  for (std::uint64_t round = 0; round < 200; ++round) {
    Random random(1, RandomStream::perturbation, round);
    Positions x = molecule.positions();
    perturb(x, framework.fixed(), PerturbationKind::gaussian, 0.05, random);
    mirrored += resolver->resolve(x, {}).converged && torsion_degree(x, 4, 0, 1, 2) * start < 0;
  }
  EXPECT_GT(mirrored, 0);
}

TEST(BuildFramework, FlatRingHasNoPucker) {
  std::vector<Vec3> flat = cyclopentane_ring().positions();
  flat[0] = {0.131, 0, 0};
  const Molecule ring(cyclopentane_ring().atoms(), cyclopentane_ring().bonds(), flat);
  EXPECT_TRUE(build_framework(ring).volumes().empty());
}

// === Contacts

TEST(BuildFramework, ContactsFollowTheRadiiOfTheElements) {
  const Molecule atoms = loose_atoms(
      {1, 6, 7, 8, 16, 11}, {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}, {5, 0, 0}});
  const Framework framework = build_framework(atoms);
  const ContactRule& rule = framework.contact_rule();
  EXPECT_DOUBLE_EQ(rule.bound(0, 1), 0.85 * (0.110 + 0.170));
  EXPECT_DOUBLE_EQ(rule.bound(2, 3), 0.85 * (0.155 + 0.152) - 0.01);
  EXPECT_DOUBLE_EQ(rule.bound(1, 4), 0.85 * (0.170 + 0.180));
  EXPECT_TRUE(rule.exclusions.empty());
  EXPECT_TRUE(rule.close_pairs.empty());
}

TEST(BuildFramework, PolarHydrogensMayComeCloserToPolarAtoms) {
  const Framework framework = build_framework(formamide());
  const ContactRule& rule = framework.contact_rule();
  EXPECT_EQ(rule.polarity,
            (std::vector<Polarity>{Polarity::none, Polarity::heavy, Polarity::heavy, Polarity::none,
                                   Polarity::hydrogen, Polarity::hydrogen}));
  EXPECT_DOUBLE_EQ(rule.rule_bound(1, 4), 0.85 * (0.152 + 0.110) - 0.05);
}

TEST(BuildFramework, NeighboursUpToThreeBondsAreExcluded) {
  const Framework framework = build_framework(heptane());
  const ContactRule& rule = framework.contact_rule();
  for (int q = 1; q <= 3; ++q) EXPECT_TRUE(rule.excluded(0, q));
  for (int q = 4; q <= 6; ++q) EXPECT_FALSE(rule.excluded(0, q));
  for (const Bar& bar : framework.bars())
    EXPECT_TRUE(rule.excluded(std::min(bar.p, bar.q), std::max(bar.p, bar.q)));
}

TEST(BuildFramework, PairThatStartsCloserKeepsItsDistance) {
  const Molecule atoms = loose_atoms({6, 6, 6}, {{0, 0, 0}, {0.2, 0, 0}, {0.6, 0, 0}});
  const Framework framework = build_framework(atoms);
  EXPECT_DOUBLE_EQ(framework.contact_rule().bound(0, 1), 0.2);
  EXPECT_DOUBLE_EQ(framework.contact_rule().bound(1, 2), 0.85 * 0.34);
  EXPECT_EQ(framework.contact_rule().close_pairs.size(), 1U);
}

TEST(BuildFramework, PairThatStartsCloserThroughAFaceOfTheBoxKeepsThatDistance) {
  const Molecule atoms = loose_atoms({6, 6}, {{0.1, 0, 0}, {1.9, 0, 0}});
  const Box box = {{2, 0, 0}, {0, 2, 0}, {0, 0, 2}};
  EXPECT_TRUE(build_framework(atoms).contact_rule().close_pairs.empty());
  EXPECT_NEAR(build_framework(atoms, {}, &box).contact_rule().bound(0, 1), 0.2, 1e-12);
}

TEST(BuildFramework, ContactsCanBeLeftOut) {
  EXPECT_TRUE(build_framework(ethane(), {.contacts = false}).contact_rule().empty());
}

// === Refusals

TEST(BuildFramework, BondedAtomsAtOnePlaceAreRefusedByName) {
  std::vector<Atom> atoms = ethane().atoms();
  atoms[0].label = "CA GLY45 A";
  std::vector<Vec3> x = ethane().positions();
  x[1] = x[0] + Vec3(1e-4, 0, 0);
  const Molecule molecule(atoms, ethane().bonds(), x);
  EXPECT_EQ(refusal_of([&] { build_framework(molecule); }),
            "CA GLY45 A and atom 1 are at one place; remove one of them or mend the coordinates");
}

TEST(BuildFramework, UnbondedAtomsAtOnePlaceAreRefusedByName) {
  const Molecule twice = loose_atoms({6, 8, 6}, {{0, 0, 0}, {1, 0, 0}, {0, 0, 0}});
  const std::string sentence =
      "atom 0 and atom 2 are at one place; remove one of them or mend the coordinates";
  EXPECT_EQ(refusal_of([&] { build_framework(twice); }), sentence);
}

TEST(BuildFramework, AtomsAtOnePlaceAreRefusedWithoutContactsToo) {
  const Molecule twice = loose_atoms({6, 8, 6}, {{0, 0, 0}, {1, 0, 0}, {0, 0, 0}});
  EXPECT_NE(refusal_of([&] { build_framework(twice, {.contacts = false}); }), "");
}

TEST(BuildFramework, AtomsThreeBondsApartAtOnePlaceAreRefused) {
  // a hydrogen of each carbon of ethane
  std::vector<Vec3> x = ethane().positions();
  x[5] = x[2];
  const Molecule molecule(ethane().atoms(), ethane().bonds(), x);
  EXPECT_NE(refusal_of([&] { build_framework(molecule); }), "");
}

TEST(BuildFramework, OptionsOutOfRangeAreRefused) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refusal = [](const FrameworkOptions& options) {
    return refusal_of([&] { build_framework(ethane(), options); });
  };
  for (const double scale : {0.0, -1.0, 1.51, nan})
    EXPECT_NE(refusal({.contact_scale = scale}).find("contact scale"), std::string::npos);
  for (const double planarity : {0.0, -10.0, 91.0, nan})
    EXPECT_NE(refusal({.planarity_degree = planarity}).find("planarity"), std::string::npos);
  for (const double allowance : {-0.01, nan}) {
    EXPECT_NE(refusal({.heavy_allowance = allowance}).find("allowance"), std::string::npos);
    EXPECT_NE(refusal({.hydrogen_allowance = allowance}).find("allowance"), std::string::npos);
  }
  EXPECT_EQ(refusal({.contact_scale = 1.5, .planarity_degree = 90}), "");
}

TEST(BuildFramework, LoneAtomIsAFramework) {
  const Framework framework = build_framework(loose_atoms({11}, {{1, 2, 3}}));
  EXPECT_EQ(framework.joint_count(), 1);
  EXPECT_TRUE(framework.bars().empty());
}

}  // namespace
}  // namespace ragdoll
