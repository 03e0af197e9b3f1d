// Tests for core/src/quality.cpp, quality_limits.cpp, clash_radii.cpp and ramachandran_density.cpp.

#include "ragdoll/quality.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>  // AngleAxisd
#include <cmath>           // sqrt
#include <numbers>         // pi

#include "clash_radii.h"
#include "examples.h"
#include "molecules.h"
#include "ragdoll/quality_limits.h"
#include "ragdoll/random.h"  // Random

namespace ragdoll {
namespace {

using namespace examples;

constexpr double degree = std::numbers::pi / 180;

Molecule molecule_of(const std::vector<int>& elements, const std::vector<Bond>& bonds,
                     const Positions& positions) {
  std::vector<Atom> atoms;
  for (const int element : elements) atoms.push_back({element, 0, 12});
  return Molecule(atoms, bonds, positions);
}

/// Atoms that are not bonded, along x.
FrameQuality apart(int first, int second, double distance) {
  const Molecule molecule = molecule_of({first, second}, {}, {{0, 0, 0}, {1, 0, 0}});
  return QualityCheck(molecule, {}).measure(Positions{{0, 0, 0}, {distance, 0, 0}});
}

TEST(Quality, InputDeviatesByNothing) {
  const Molecule molecule = methylacetamide();
  QualityTerms terms;
  terms.omegas = {{3, 0, 2, 4}};
  const FrameQuality q = QualityCheck(molecule, terms).measure(molecule.positions());
  EXPECT_EQ(q.bond_rms, 0);
  EXPECT_EQ(q.bond_max, 0);
  EXPECT_EQ(q.angle_rms, 0);
  EXPECT_EQ(q.angle_max, 0);
  EXPECT_EQ(q.centres_inverted, 0);
  EXPECT_EQ(q.clashes, 0);
}

TEST(Quality, KnownDisplacementsGiveKnownDeviations) {
  const Molecule molecule =
      molecule_of({6, 6, 6}, {{0, 1}, {1, 2}}, {{0.15, 0, 0}, {0, 0, 0}, {0, 0.15, 0}});
  QualityTerms terms;
  terms.ideal_bonds = {{0, 1, 0.14, 0.002}};
  terms.ideal_angles = {{0, 1, 2, 105, 3}};
  const Vec3 turned(0.16 * std::cos(120 * degree), 0.16 * std::sin(120 * degree), 0);
  const FrameQuality q =
      QualityCheck(molecule, terms).measure(Positions{{0.15, 0, 0}, {0, 0, 0}, turned});
  EXPECT_NEAR(q.bond_max, 0.01, 1e-12);
  EXPECT_NEAR(q.bond_rms, 0.01 / std::sqrt(2), 1e-12);
  EXPECT_NEAR(q.angle_max, 30, 1e-9);
  EXPECT_NEAR(q.angle_rms, 30, 1e-9);
  EXPECT_NEAR(q.bond_rmsz, 5, 1e-9);   // one bond 0.01 too long
  EXPECT_NEAR(q.angle_rmsz, 5, 1e-9);  // 120 in the place of 105
}

TEST(Quality, HeavyAtomsClashFromFourTenthsOfAnAngstromOn) {
  struct Case {
    int first, second;
    double sum;
  };
  for (const auto& [first, second, sum] :
       {Case{6, 6, 0.34}, Case{6, 7, 0.325}, Case{6, 8, 0.322}, Case{6, 16, 0.35}}) {
    EXPECT_EQ(apart(first, second, sum - 0.039).clashes, 0) << first << ' ' << second;
    EXPECT_EQ(apart(first, second, sum - 0.041).clashes, 1) << first << ' ' << second;
    EXPECT_NEAR(apart(first, second, sum - 0.061).clash_worst, 0.021, 1e-6);
  }
  // N and O may come nearer by as much again
  EXPECT_EQ(apart(7, 8, 0.307 - 0.079).clashes, 0);
  EXPECT_EQ(apart(7, 8, 0.307 - 0.081).clashes, 1);
  EXPECT_EQ(apart(8, 8, 0.304 - 0.079).clashes, 0);
  EXPECT_EQ(apart(8, 8, 0.304 - 0.081).clashes, 1);
  // no clash of sulfurs, hydrogens or metals among heavy atoms
  EXPECT_EQ(apart(16, 16, 0.2).clashes, 0);
  EXPECT_EQ(apart(1, 6, 0.1).clashes, 0);
  EXPECT_EQ(apart(30, 8, 0.2).clashes, 0);
}

TEST(Quality, PairsWithinFourBondsDoNotClash) {
  // a chain whose ends come together
  for (const int atoms : {5, 6}) {
    std::vector<Bond> bonds;
    Positions stretched, closed;
    for (int i = 0; i < atoms; ++i) {
      if (i > 0) bonds.push_back({i - 1, i});
      stretched.push_back({0.15 * i, 0, 0});
      const double turn = 2 * std::numbers::pi * i / atoms;
      closed.push_back(0.2 * Vec3(std::cos(turn), std::sin(turn), 0));
    }
    const Molecule molecule =
        molecule_of(std::vector<int>(std::size_t(atoms), 6), bonds, stretched);
    EXPECT_EQ(QualityCheck(molecule, {}).measure(closed).clashes, atoms == 5 ? 0 : 1);
  }
}

TEST(Quality, AllAtomClashesKnowHydrogensAndTheirBonds) {
  // a hydrogen on carbon beside a carbon; a hydrogen on nitrogen beside an oxygen and a carbon
  const auto clashes = [](int donor, int other, double distance) {
    const Molecule molecule = molecule_of({donor, 1, other}, {{0, 1, BondOrder::single}},
                                          {{0, 0, 0}, {0.2, 0, 0}, {1, 0, 0}});
    // a long bond, so that the donor itself is out of reach
    return QualityCheck(molecule, {})
        .measure(Positions{{0, 0, 0}, {0.2, 0, 0}, {0.2 + distance, 0, 0}})
        .all_atom_clashes;
  };
  EXPECT_EQ(clashes(6, 6, 0.117 + 0.170 - 0.039), 0);
  EXPECT_EQ(clashes(6, 6, 0.117 + 0.170 - 0.041), 1);
  EXPECT_EQ(clashes(7, 6, 0.100 + 0.170 - 0.039), 0);
  EXPECT_EQ(clashes(7, 6, 0.100 + 0.170 - 0.041), 1);
  EXPECT_EQ(clashes(7, 8, 0.100 + 0.140 - 0.099), 0);
  EXPECT_EQ(clashes(7, 8, 0.100 + 0.140 - 0.101), 1);
}

TEST(Quality, ClashesAreThoseOfLookingAtAllPairs) {
  Random random(3, RandomStream::generate, 0);
  std::vector<int> elements;
  Positions x;
  for (int i = 0; i < 300; ++i) {
    elements.push_back(std::array{6, 7, 8, 16, 1, 30}[random.below(6)]);
    x.push_back(1.2 * Vec3(random.uniform(), random.uniform(), random.uniform()));
  }
  const Molecule molecule = molecule_of(elements, {}, x);
  for (const bool boxed : {false, true}) {
    const Box box{{1.2, 0, 0}, {0, 1.3, 0}, {0.1, 0, 1.25}};
    std::int64_t heavy = 0, all = 0;
    for (std::size_t i = 0; i < x.size(); ++i)
      for (std::size_t j = i + 1; j < x.size(); ++j) {
        const int a = elements[i], b = elements[j];
        Vec3 d = x[j] - x[i];
        if (boxed) d = box.minimum_image(d);
        const double h = heavy_clash_radius(a) * heavy_clash_radius(b) > 0
                             ? heavy_clash_radius(a) + heavy_clash_radius(b)
                             : 0;
        const bool polar = (a == 7 || a == 8) && (b == 7 || b == 8);
        heavy += h > 0 && !(a == 16 && b == 16) && h - d.norm() >= (polar ? 0.08 : 0.04);
        const double r =
            all_atom_clash_radius(molecule, int(i)) * all_atom_clash_radius(molecule, int(j)) > 0
                ? all_atom_clash_radius(molecule, int(i)) + all_atom_clash_radius(molecule, int(j))
                : 0;
        all += r > 0 && r - d.norm() >= 0.04;
      }
    const FrameQuality q = QualityCheck(molecule, {}).measure(x, boxed ? &box : nullptr);
    EXPECT_GT(heavy, 100);
    EXPECT_EQ(q.clashes, heavy);
    EXPECT_EQ(q.all_atom_clashes, all);
  }
}

TEST(Quality, PeptideBondsTurnFromTransOrFromCisAsTheInputIs) {
  // a-b-c-d with a torsion of so many degrees
  const auto at = [](double torsion) {
    return Positions{{0.1, 0.1, 0},
                     {0.1, 0, 0},
                     {0, 0, 0},
                     {0, 0.1 * std::cos(torsion * degree), 0.1 * std::sin(torsion * degree)}};
  };
  const std::vector<Bond> bonds = {{0, 1}, {1, 2}, {2, 3}};
  QualityTerms terms;
  terms.omegas = {{0, 1, 2, 3}};
  const QualityCheck trans(molecule_of({6, 6, 7, 6}, bonds, at(170)), terms);
  EXPECT_NEAR(trans.measure(at(170)).omega_rms, 10, 1e-9);
  EXPECT_NEAR(trans.measure(at(-155)).omega_max, 25, 1e-9);
  EXPECT_EQ(trans.measure(at(-151)).omegas_off, 0);
  EXPECT_EQ(trans.measure(at(149)).omegas_off, 1);
  EXPECT_NEAR(trans.measure(at(0)).omega_max, 180, 1e-9);
  const QualityCheck cis(molecule_of({6, 6, 7, 6}, bonds, at(5)), terms);
  EXPECT_NEAR(cis.measure(at(-20)).omega_rms, 20, 1e-9);
  EXPECT_EQ(cis.measure(at(31)).omegas_off, 1);
}

TEST(Quality, MirroredCentresAreInvertedAndTurnedOnesAreNot) {
  const Positions tetrahedron = {
      {0, 0, 0}, {0.1, 0.1, 0.1}, {0.1, -0.1, -0.1}, {-0.1, 0.1, -0.1}, {-0.1, -0.1, 0.1}};
  const std::vector<Bond> bonds = {{0, 1}, {0, 2}, {0, 3}, {0, 4}};
  QualityTerms terms;
  terms.alphas = {0};
  const Molecule molecule = molecule_of({6, 7, 6, 6, 1}, bonds, tetrahedron);
  const QualityCheck check(molecule, terms);
  EXPECT_EQ(check.centre_count(), 1);
  Positions turned = tetrahedron, mirrored = tetrahedron, through = tetrahedron;
  for (Vec3& point : turned) point = Eigen::AngleAxisd(1, Vec3(1, 2, 3).normalized()) * point;
  for (Vec3& point : mirrored) point[0] = -point[0];
  through[4] = 0.2 * Vec3(1, 1, -1);  // the hydrogen went through the face of the others
  EXPECT_EQ(check.measure(turned).centres_inverted, 0);
  EXPECT_EQ(check.measure(mirrored).centres_inverted, 1);
  EXPECT_EQ(check.measure(mirrored).alphas_inverted, 1);
  EXPECT_EQ(check.measure(through).centres_inverted, 1);
  // a flat centre has no hand
  const Molecule flat = molecule_of({6, 8, 7, 6}, {{0, 1}, {0, 2}, {0, 3}},
                                    {{0, 0, 0}, {0.1, 0, 0}, {-0.05, 0.1, 0}, {-0.05, -0.1, 0}});
  EXPECT_EQ(QualityCheck(flat, {}).centre_count(), 0);
}

TEST(Quality, BoundsAreToldByGroup) {
  const Molecule molecule = molecule_of({6, 6, 6}, {}, {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}});
  QualityTerms terms;
  terms.bounds = {{0, 1, 0.9, 0}, {0, 2, 1.5, 1}, {0, 1, 2, 1}};
  terms.groups = 3;
  const FrameQuality q = QualityCheck(molecule, terms).measure(molecule.positions());
  ASSERT_EQ(q.excess.size(), 3U);
  EXPECT_NEAR(q.excess[0], 0.1, 1e-12);
  EXPECT_NEAR(q.excess[1], 0.5, 1e-12);
  EXPECT_EQ(q.excess[2], 0);
}

TEST(Quality, TheMapTellsByItsNearestPointAndGoesOnAcrossItsEdges) {
  // four points a turn: -180, -90, 0, 90
  std::vector<double> density(16, 0);
  density[0] = 20;         // -180, -180
  density[1 * 4 + 2] = 5;  // psi -90, phi 0
  const RamachandranDensity map(density, 17, 1);
  for (const double edge : {-180.0, 180.0, 140.0, -140.0, -539.0})
    EXPECT_EQ(map.region(edge, 179), RamachandranRegion::core) << edge;
  EXPECT_EQ(map.region(10, -80), RamachandranRegion::allowed);
  EXPECT_EQ(map.region(-80, 10), RamachandranRegion::outlier);
  EXPECT_EQ(refusal_of([] { RamachandranDensity(std::vector<double>(5), 2, 1); }),
            "a Ramachandran map of 5 values is no square grid");
}

TEST(Quality, WhatMakesNoSenseIsRefused) {
  const Molecule molecule = molecule_of({6, 6}, {}, {{0, 0, 0}, {1, 0, 0}});
  QualityTerms terms;
  terms.alphas = {2};
  EXPECT_EQ(refusal_of([&] { QualityCheck(molecule, terms); }),
            "a term of quality names atom 2, which does not exist");
  const QualityCheck check(molecule, {});
  EXPECT_EQ(refusal_of([&] {
              check.measure(Positions{{0, 0, 0}});
            }),
            "a frame has 1 positions instead of 2");
  EXPECT_EQ(refusal_of([&] {
              check.measure(Positions{{0, 0, 0}, {NAN, 0, 0}});
            }),
            "a frame has a coordinate that is not finite");
}

TEST(QualityJudge, AFrameIsBelowALimitOnlyBeyondIt) {
  const Positions start = {{0, 0, 0}, {0.1, 0, 0}, {1, 0, 0}};
  const auto check =
      std::make_shared<const QualityCheck>(molecule_of({6, 6, 6}, {{0, 1}}, start), QualityTerms{});
  const Positions longer = {{0, 0, 0}, {0.11, 0, 0}, {1, 0, 0}};
  EXPECT_EQ(QualityJudge(check, {}).fault(longer).words, "");
  EXPECT_EQ(QualityJudge(check, {.bond_rms = 0.011}).fault(longer).words, "");
  EXPECT_EQ(QualityJudge(check, {.bond_rms = 0.009}).fault(longer).words,
            "bonds off by an RMS of 0.1 angstrom, at most 0.09");
  const Positions close = {{0, 0, 0}, {0.1, 0, 0}, {0.35, 0, 0}};
  EXPECT_EQ(QualityJudge(check, {.clash_growth = 1000. / 3 + 1}).fault(close).words, "");
  EXPECT_EQ(QualityJudge(check, {.clash_growth = 300}).fault(close).words,
            "clashes 333 more per 1000 atoms, at most 300");
}

TEST(QualityJudge, WhatTheInputHasIsNoFault) {
  const Positions start = {{0, 0, 0}, {0.2, 0, 0}};
  const auto check =
      std::make_shared<const QualityCheck>(molecule_of({6, 6}, {}, start), QualityTerms{});
  ASSERT_EQ(check->measure(start).clashes, 1);
  EXPECT_EQ(QualityJudge(check, {.clash_growth = 0}).fault(start).words, "");
}

}  // namespace
}  // namespace ragdoll
