// Tests for core/src/ring_conformers.cpp and the files it is made of.

#include "ragdoll/ring_conformers.h"

#include <gtest/gtest.h>

#include <algorithm>  // sort, count_if
#include <cmath>      // cos, sin, abs
#include <memory>
#include <numbers>  // pi

#include "molecules.h"
#include "ragdoll/build_framework.h"
#include "ragdoll/error.h"
#include "ragdoll/resolver.h"  // worst_violation, inverted_centres
#include "ring_sterics.h"
#include "ring_torsions.h"

namespace ragdoll {
namespace {

constexpr double degree = std::numbers::pi / 180;

/// A puckered ring of carbons, each with two hydrogens: ring atoms first, then the pairs.
Molecule ring_of_methylenes(const std::vector<double>& heights, double bond = 0.153) {
  const int n = int(heights.size());
  std::vector<Atom> atoms;
  std::vector<Bond> bonds;
  std::vector<Vec3> x;
  // the radius at which bonds have their length on average
  double rise = 0;
  for (int k = 0; k < n; ++k)
    rise += std::pow(heights[std::size_t((k + 1) % n)] - heights[std::size_t(k)], 2) / n;
  const double radius = std::sqrt(bond * bond - rise) / (2 * std::sin(std::numbers::pi / n));
  for (int k = 0; k < n; ++k) {
    const double angle = 2 * std::numbers::pi * k / n;
    atoms.push_back({6, 0, 12.011, {}});
    x.push_back({radius * std::cos(angle), radius * std::sin(angle), heights[std::size_t(k)]});
    bonds.push_back({k, (k + 1) % n, BondOrder::single});
  }
  for (int k = 0; k < n; ++k) {
    const Vec3 here = x[std::size_t(k)];
    const Vec3 u = (x[std::size_t((k + 1) % n)] - here).normalized(),
               v = (x[std::size_t((k + n - 1) % n)] - here).normalized();
    const Vec3 out = -(u + v).normalized(), across = u.cross(v).normalized();
    for (const int side : {1, -1}) {
      bonds.push_back({k, int(atoms.size()), BondOrder::single});
      atoms.push_back({1, 0, 1.008, {}});
      x.push_back(here +
                  0.109 * (std::cos(54 * degree) * out + side * std::sin(54 * degree) * across));
    }
  }
  return Molecule(atoms, bonds, x);
}

Molecule cyclohexane() {
  return ring_of_methylenes({0.025, -0.025, 0.025, -0.025, 0.025, -0.025});
}

std::vector<double> ring_torsions(const std::vector<Vec3>& x, int n) {
  std::vector<double> torsions;
  for (int k = 0; k < n; ++k)
    torsions.push_back(torsion_of(x[std::size_t(k)], x[std::size_t((k + 1) % n)],
                                  x[std::size_t((k + 2) % n)], x[std::size_t((k + 3) % n)]) /
                       degree);
  return torsions;
}

TEST(RingConformers, CyclohexaneHasChairsBelowTwistBoats) {
  const std::vector<RingPool> pools = ring_conformers(cyclohexane(), {});
  ASSERT_EQ(pools.size(), 1U);
  const RingPool& pool = pools[0];
  EXPECT_EQ(pool.ring_atoms, 6);
  EXPECT_EQ(pool.atoms.size(), 18U);
  ASSERT_EQ(pool.energies.size(), pool.conformations.size());
  EXPECT_TRUE(std::is_sorted(pool.energies.begin(), pool.energies.end()));
  // in a chair all torsions are near 56 degrees and signs alternate; a twist boat has two near 64
  const auto is_chair = [](const std::vector<double>& t) {
    for (std::size_t k = 0; k < 6; ++k)
      if (std::abs(std::abs(t[k]) - 56) > 10 || t[k] * t[(k + 1) % 6] > 0) return false;
    return true;
  };
  const auto is_twist_boat = [](std::vector<double> t) {
    for (double& one : t) one = std::abs(one);
    std::sort(t.begin(), t.end());
    return t[0] > 20 && t[3] < 45 && t[4] > 55;
  };
  EXPECT_TRUE(is_chair(ring_torsions(pool.conformations[0], 6)));
  EXPECT_GE(std::count_if(pool.conformations.begin() + 1, pool.conformations.end(),
                          [&](const auto& x) { return is_twist_boat(ring_torsions(x, 6)); }),
            1);
}

TEST(RingConformers, BondsKeepTheirLengthsAndAnglesOfRingsPlayByNoMoreThanAllowed) {
  const Molecule molecule = ring_of_methylenes({0.03, 0, -0.03, -0.01, 0.03, 0.01, -0.03, -0.01});
  RingSettings settings;
  settings.angle_play_degree = 2;
  const std::vector<RingPool> pools = ring_conformers(molecule, {}, settings);
  ASSERT_EQ(pools.size(), 1U);
  const auto angle = [](const std::vector<Vec3>& x, int k) {
    const Vec3 u = (x[std::size_t((k + 7) % 8)] - x[std::size_t(k)]).normalized(),
               v = (x[std::size_t((k + 1) % 8)] - x[std::size_t(k)]).normalized();
    return std::acos(u.dot(v)) / degree;
  };
  double mean = 0;
  for (int k = 0; k < 8; ++k) mean += angle(molecule.positions(), k) / 8;
  for (const std::vector<Vec3>& x : pools[0].conformations) {
    for (int k = 0; k < 8; ++k) {
      EXPECT_LT(std::abs(angle(x, k) - mean), 2.1);
      const auto length = [k](const std::vector<Vec3>& at) {
        return (at[std::size_t((k + 1) % 8)] - at[std::size_t(k)]).norm();
      };
      EXPECT_NEAR(length(x), length(molecule.positions()), 1e-4);
    }
  }
}

TEST(RingConformers, HydrogensOfAMethyleneDoNotChangePlaces) {
  const Molecule molecule = cyclohexane();
  const auto hand = [](const std::vector<Vec3>& x, int k) {
    return signed_volume(x[std::size_t((k + 5) % 6)], x[std::size_t((k + 1) % 6)],
                         x[std::size_t(6 + 2 * k)], x[std::size_t(7 + 2 * k)]);
  };
  for (const RingPool& pool : ring_conformers(molecule, {}))
    for (const std::vector<Vec3>& x : pool.conformations)
      for (int k = 0; k < 6; ++k) EXPECT_GT(hand(x, k) * hand(molecule.positions(), k), 0);
}

TEST(RingConformers, ConformationsSatisfyThePliantFramework) {
  const Molecule molecule = cyclohexane();
  RingSettings settings;
  const std::vector<RingSystem> systems = ring_systems(molecule);
  const Framework pliant = with_pliant_rings(build_framework(molecule, settings.framework),
                                             molecule, systems, settings.angle_play_degree);
  for (const RingPool& pool : ring_conformers(molecule, {}, settings))
    for (const std::vector<Vec3>& x : pool.conformations) {
      std::vector<Vec3> all(x.size());
      for (std::size_t k = 0; k < x.size(); ++k) all[std::size_t(pool.atoms[k])] = x[k];
      EXPECT_LT(worst_violation(pliant, all, nullptr).relative, 2 * settings.tolerance);
      EXPECT_EQ(inverted_centres(pliant, all), 0);
    }
}

TEST(RingConformers, AromaticRingsAndChainsHaveNoPools) {
  EXPECT_TRUE(ring_conformers(examples::benzene(), {}).empty());
  EXPECT_TRUE(ring_conformers(examples::heptane(), {}).empty());
}

TEST(RingConformers, AFiveRingPuckersEitherWay) {
  const std::vector<RingPool> pools =
      ring_conformers(examples::cyclopentane_ring(), {}, {.count = 30, .fill = true});
  ASSERT_EQ(pools.size(), 1U);
  bool up = false, down = false;
  for (const std::vector<Vec3>& x : pools[0].conformations)
    for (const double t : ring_torsions(x, 5)) (t > 0 ? up : down) |= std::abs(t) > 25;
  EXPECT_TRUE(up && down);
}

TEST(RingConformers, GapsAreFilledUpToTheCountWhereAskedFor) {
  const Molecule molecule = ring_of_methylenes({0.03, 0, -0.03, -0.01, 0.03, 0.01, -0.03, -0.01});
  const std::vector<RingPool> few = ring_conformers(molecule, {}, {.count = 60});
  const std::vector<RingPool> many = ring_conformers(molecule, {}, {.count = 60, .fill = true});
  ASSERT_EQ(few.size(), 1U);
  ASSERT_EQ(many.size(), 1U);
  EXPECT_EQ(few[0].minima, int(few[0].conformations.size()));
  EXPECT_LT(few[0].conformations.size(), 60U);
  EXPECT_EQ(many[0].conformations.size(), 60U);
  EXPECT_LT(many[0].minima, 60);
}

TEST(RingConformers, TheSameSeedGivesTheSameShapesAndAnotherSeedOthers) {
  const Molecule molecule = ring_of_methylenes({0.03, 0, -0.03, -0.01, 0.03, 0.01, -0.03, -0.01});
  const RingSettings settings{.count = 40, .seed = 5, .fill = true};
  const auto one = ring_conformers(molecule, {}, settings);
  const auto again = ring_conformers(molecule, {}, settings);
  const auto other = ring_conformers(molecule, {}, {.count = 40, .seed = 6, .fill = true});
  ASSERT_EQ(one.size(), 1U);
  EXPECT_EQ(one[0].conformations, again[0].conformations);
  EXPECT_NE(one[0].conformations, other[0].conformations);
}

TEST(RingConformers, ALikedTorsionIsWhereTermsWantIt) {
  // a term that likes 0 degrees instead of 60: boats and flat parts come before chairs
  std::vector<TorsionTerm> terms;
  for (int k = 0; k < 6; ++k)
    terms.push_back({k, (k + 1) % 6, (k + 2) % 6, (k + 3) % 6, {0, 0, 7}, {0, 0, -1}});
  const auto pools = ring_conformers(cyclohexane(), terms);
  ASSERT_EQ(pools.size(), 1U);
  double least = 180;
  for (const double t : ring_torsions(pools[0].conformations[0], 6))
    least = std::min(least, std::abs(t));
  EXPECT_LT(least, 20);
}

TEST(RingConformers, SettingsAndTermsThatMakeNoSenseAreRefused) {
  EXPECT_THROW(ring_conformers(cyclohexane(), {}, {.count = 0}), Error);
  EXPECT_THROW(ring_conformers(cyclohexane(), {}, {.tolerance = 0}), Error);
  EXPECT_THROW(ring_conformers(cyclohexane(), {}, {.angle_play_degree = -1}), Error);
  const TorsionTerm unknown{0, 1, 2, 99, {}, {}};
  EXPECT_THROW(ring_conformers(cyclohexane(), std::span(&unknown, 1)), Error);
}

// === Torsions and crowding

TEST(RingTorsions, LeadingATorsionTurnsItTowardsWhatItLikes) {
  std::vector<Vec3> x = {{0.14, 0.05, 0}, {0, 0, 0}, {0, 0, 0.15}, {0.1, 0.1, 0.2}};
  const TorsionScore score({{{0, 1, 2, 3, {0, 0, 5}, {0, 0, 1}}, 0}});
  double energy = score.energy(x);
  for (int round = 0; round < 40; ++round) {
    std::vector<Vec3> move(4, Vec3::Zero());
    score.lead(x, move);
    Vec3 sum = Vec3::Zero();
    for (const Vec3& m : move) sum += m;
    EXPECT_LT(sum.norm(), 1e-12);
    for (std::size_t k = 0; k < 4; ++k) x[k] += move[k];
    EXPECT_LE(score.energy(x), energy + 1e-9);
    energy = score.energy(x);
  }
  EXPECT_NEAR(std::abs(torsion_of(x[0], x[1], x[2], x[3])) / degree, 60, 1);
}

TEST(RingTorsions, SymmetryMakesShiftedTorsionsOfACarbocycleTheSame) {
  const Molecule molecule = cyclohexane();
  const std::vector<RingSystem> systems = ring_systems(molecule);
  const RingTorsions torsions(molecule, systems[0], PliantRings(molecule, systems));
  EXPECT_EQ(torsions.symmetries(), 12);
  const std::vector<float> one = {1, 0.5F, -1, 1, 0.5F, -1}, shifted = {-1, 1, 0.5F, -1, 1, 0.5F};
  EXPECT_NEAR(torsions.distance(one, shifted), 0, 1e-6);
  std::vector<float> mirrored = one;
  for (float& t : mirrored) t = -t;
  EXPECT_GT(torsions.distance(one, mirrored), 0.5);
}

TEST(RingSterics, PushingFollowsTheGradientOfTheEnergy) {
  const Molecule molecule =
      ring_of_methylenes({0.02, -0.02, 0.02, -0.02, 0.02, -0.02, 0.02, -0.02});
  std::vector<int> all(molecule.atoms().size());
  for (std::size_t k = 0; k < all.size(); ++k) all[k] = int(k);
  const RingSterics sterics(molecule, all);
  std::vector<Vec3> x = molecule.positions(), push(x.size(), Vec3::Zero());
  ASSERT_GT(sterics.energy(x), 1);
  sterics.push(x, 1, push);
  const double h = 1e-6;
  for (std::size_t k = 0; k < x.size(); ++k)
    for (Eigen::Index c = 0; c < 3; ++c) {
      std::vector<Vec3> more = x, less = x;
      more[k][c] += h;
      less[k][c] -= h;
      const double slope = (sterics.energy(more) - sterics.energy(less)) / (2 * h);
      EXPECT_NEAR(push[k][c], -slope, 1e-4 * (1 + std::abs(slope)));
    }
}

}  // namespace
}  // namespace ragdoll
