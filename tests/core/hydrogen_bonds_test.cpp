// Tests for core/src/hydrogen_bonds.cpp.

#include "ragdoll/hydrogen_bonds.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>  // AngleAxisd
#include <cmath>           // cos, exp, pow, sin
#include <limits>
#include <numbers>  // pi

#include "examples.h"
#include "molecules.h"

namespace ragdoll {
namespace {

using namespace examples;

constexpr double degree = std::numbers::pi / 180;
constexpr double kcal = kilojoule_per_kilocalorie;

const HydrogenBondOptions all = {.weakest = 0};

/// Two molecules in one.
Molecule both(const Molecule& one, const Molecule& other) {
  std::vector<Atom> atoms = one.atoms();
  std::vector<Bond> bonds = one.bonds();
  Positions x = one.positions();
  const int first = int(atoms.size());
  atoms.insert(atoms.end(), other.atoms().begin(), other.atoms().end());
  for (const Bond& bond : other.bonds())
    bonds.push_back({bond.a + first, bond.b + first, bond.order});
  x.insert(x.end(), other.positions().begin(), other.positions().end());
  return Molecule(std::move(atoms), std::move(bonds), std::move(x));
}

/// An OH at the origin that points along x, with another H; and an O at `distance`, with two H at
/// `phi` to the H of the first.
Molecule water_dimer(double distance, double phi_degree, double bend_degree = 0) {
  const auto water = [](const Positions& x) {
    return Molecule({{8, 0, 16}, {1, 0, 1}, {1, 0, 1}}, {{0, 1}, {0, 2}}, x);
  };
  const Vec3 hydrogen(0.096, 0, 0);
  const Vec3 o = distance * Vec3(std::cos(bend_degree * degree), std::sin(bend_degree * degree), 0);
  // rotated from the direction to the first H by phi
  const Vec3 back = (hydrogen - o).normalized();
  const Eigen::AngleAxisd turn(phi_degree * degree, Vec3::UnitZ());
  const Vec3 base = 0.096 * (turn * back);
  const Eigen::AngleAxisd about(180 * degree, back);
  return both(water({Vec3::Zero(), hydrogen, {-0.024, 0.093, 0}}),
              water({o, o + base, o + about * base}));
}

/// A formamide whose N-H points at the O of another, planes turned against each other.
Molecule formamide_dimer(double donor_acceptor, double phi_degree, double turn_degree) {
  const Molecule donor = formamide(), acceptor = formamide();
  const Positions &x = donor.positions(), &y = acceptor.positions();
  const Vec3 along = (x[4] - x[2]).normalized(), o = x[2] + donor_acceptor * along;
  // C of the acceptor, so that H...O=C is phi, in the donor's plane
  const Vec3 to_carbon = Eigen::AngleAxisd(phi_degree * degree, Vec3::UnitZ()) * -along;
  const Vec3 from = (y[0] - y[1]).normalized();
  const Eigen::AngleAxisd turn(turn_degree * degree, to_carbon);
  const Eigen::Quaterniond align = Eigen::Quaterniond::FromTwoVectors(from, to_carbon);
  Positions placed;
  for (const Vec3& p : y) placed.push_back(o + turn * (align * (p - y[1])));
  return both(donor, Molecule(acceptor.atoms(), acceptor.bonds(), placed));
}

/// Energy of the strongest bond between given atoms, kcal/mol; 0 where there is none.
double energy_of(const Molecule& molecule, int hydrogen, int acceptor) {
  for (const HydrogenBond& bond : hydrogen_bonds(molecule, all))
    if (bond.hydrogen == hydrogen && bond.acceptor == acceptor) return bond.energy / kcal;
  return 0;
}

double well(double depth, double place, double d) {
  return depth * (5 * std::pow(place / d, 12) - 6 * std::pow(place / d, 10));
}

TEST(HydrogenBonds, AStraightBondOfTwoWatersAtItsBestHasEightKilocalories) {
  const auto bonds = hydrogen_bonds(water_dimer(0.28, 109.5));
  ASSERT_EQ(bonds.size(), 1U);
  EXPECT_EQ(bonds[0].donor, 0);
  EXPECT_EQ(bonds[0].hydrogen, 1);
  EXPECT_EQ(bonds[0].acceptor, 3);
  EXPECT_NEAR(bonds[0].energy, -8 * 4.184, 1e-9);
  EXPECT_NEAR(bonds[0].donor_acceptor, 0.28, 1e-12);
  EXPECT_NEAR(bonds[0].hydrogen_acceptor, 0.184, 1e-12);
  EXPECT_NEAR(bonds[0].angle_degree, 180, 1e-4);
  EXPECT_FALSE(bonds[0].salt_bridge);
}

TEST(HydrogenBonds, TetrahedralPairsLoseByDistanceBendAndBase) {
  EXPECT_NEAR(energy_of(water_dimer(0.30, 109.5), 1, 3), well(8, 2.8, 3.0), 1e-9);
  const double off = std::cos(20.5 * degree);
  EXPECT_NEAR(energy_of(water_dimer(0.28, 130), 1, 3), -8 * off * off, 1e-9);
  const Molecule bent = water_dimer(0.28, 109.5, 10);
  const double theta = hydrogen_bonds(bent, all).at(0).angle_degree * degree;
  ASSERT_LT(theta, 170 * degree);
  EXPECT_NEAR(energy_of(bent, 1, 3),
              -8 * std::pow(std::cos(theta), 2) * std::exp(-std::pow(std::numbers::pi - theta, 6)),
              1e-9);
}

TEST(HydrogenBonds, FlatPairsLoseByTheAngleAtTheBaseOrOfTheirPlanes) {
  // in one plane the angle between the normals is 180 degrees
  EXPECT_NEAR(energy_of(formamide_dimer(0.28, 120, 0), 4, 7), -8, 1e-6);
  EXPECT_NEAR(energy_of(formamide_dimer(0.28, 120, 180), 4, 7), -8, 1e-6);
  // across it is 90, and the base decides
  EXPECT_NEAR(energy_of(formamide_dimer(0.28, 120, 90), 4, 7), -8 * 0.25, 1e-6);
  EXPECT_NEAR(energy_of(formamide_dimer(0.28, 135, 90), 4, 7), -8 * 0.5, 1e-6);
}

TEST(HydrogenBonds, AFlatAcceptorOfATetrahedralDonorLosesByItsBaseAlone) {
  const Molecule flat = formamide_dimer(0.28, 120, 30);
  // the donor's C becomes saturated: its bonds are single
  std::vector<Bond> bonds = flat.bonds();
  bonds[0].order = BondOrder::single;
  const Molecule molecule(flat.atoms(), bonds, flat.positions());
  EXPECT_NEAR(energy_of(molecule, 4, 7), -8 * 0.25, 1e-6);
}

TEST(HydrogenBonds, ATetrahedralAcceptorOfAFlatDonorLosesByTheBendTwice) {
  // the acceptor's C = O becomes single, with a hydrogen on it: an alcohol
  const Molecule flat = formamide_dimer(0.29, 120, 30);
  std::vector<Bond> bonds = flat.bonds();
  bonds[5].order = BondOrder::single;
  Positions x = flat.positions();
  x[4] = x[2] + Eigen::AngleAxisd(12 * degree, Vec3::UnitZ()) * (x[4] - x[2]);
  const Molecule molecule(flat.atoms(), bonds, x);
  const Vec3 u = (x[2] - x[4]).normalized(), v = (x[7] - x[4]).normalized();
  const double theta = std::acos(u.dot(v));
  const double along =
      std::pow(std::cos(theta), 2) * std::exp(-std::pow(std::numbers::pi - theta, 6));
  EXPECT_NEAR(energy_of(molecule, 4, 7), well(8, 2.8, 2.9) * along * along, 1e-9);
}

/// An ammonium whose H points at an oxygen of a formate at `distance`; bent by an angle at H.
Molecule ion_pair(double distance, double bend_degree) {
  const Vec3 h(0.101, 0, 0);
  // the oxygen lies at `distance` of N, seen from H under the bend
  const double bend = bend_degree * degree;
  const double along = -0.101 * std::cos(bend) +
                       std::sqrt(distance * distance - std::pow(0.101 * std::sin(bend), 2));
  const Vec3 o = h + along * Vec3(std::cos(bend), std::sin(bend), 0);
  return Molecule({{7, 1, 14}, {1, 0, 1}, {8, -1, 16}, {6, 0, 12}, {8, 0, 16}},
                  {{0, 1}, {2, 3}, {3, 4, BondOrder::double_bond}},
                  {Vec3::Zero(), h, o, o + Vec3(0, 0.125, 0), o + Vec3(0.11, 0.18, 0)});
}

TEST(HydrogenBonds, ASaltBridgeHasTenKilocaloriesWhateverItsAngleAboveTheLeast) {
  for (const double bend : {0.0, 30.0, 65.0}) {
    const auto bonds = hydrogen_bonds(ion_pair(0.2825, bend));
    ASSERT_FALSE(bonds.empty()) << bend;
    EXPECT_TRUE(bonds[0].salt_bridge);
    EXPECT_NEAR(bonds[0].energy / kcal, -10, 1e-9);
    EXPECT_NEAR(bonds[0].angle_degree, 180 - bend, 1e-4);
  }
  EXPECT_TRUE(hydrogen_bonds(ion_pair(0.2825, 75)).empty());
}

TEST(HydrogenBonds, ASaltBridgeReachesFurther) {
  const double far = 0.39;
  EXPECT_NEAR(energy_of(ion_pair(far, 0), 1, 2), well(10, 3.2, 3.9 + 0.375), 1e-9);
  EXPECT_TRUE(hydrogen_bonds(water_dimer(far, 109.5), all).empty());
}

TEST(HydrogenBonds, BothOxygensOfACarboxylateAreItsCharge) {
  const Molecule pair = ion_pair(0.2825, 0);
  std::vector<Atom> atoms = pair.atoms();
  std::swap(atoms[2].formal_charge, atoms[4].formal_charge);
  const auto bonds = hydrogen_bonds(Molecule(atoms, pair.bonds(), pair.positions()));
  ASSERT_FALSE(bonds.empty());
  EXPECT_EQ(bonds[0].acceptor, 2);
  EXPECT_TRUE(bonds[0].salt_bridge);
}

TEST(HydrogenBonds, SulfurReachesFurtherThanOxygen) {
  const Molecule dimer = water_dimer(0.37, 109.5);
  EXPECT_TRUE(hydrogen_bonds(dimer, all).empty());
  std::vector<Atom> atoms = dimer.atoms();
  atoms[3].element = 16;
  EXPECT_EQ(hydrogen_bonds(Molecule(atoms, dimer.bonds(), dimer.positions()), all).size(), 1U);
}

TEST(HydrogenBonds, ThoseWithoutALonePairAcceptNone) {
  const Molecule dimer = water_dimer(0.28, 109.5);
  ASSERT_FALSE(hydrogen_bonds(dimer).empty());
  for (const Atom& acceptor : {Atom{6, 0, 12}, Atom{9, 0, 19}, Atom{8, 1, 16}, Atom{7, 1, 14}}) {
    std::vector<Atom> atoms = dimer.atoms();
    atoms[3] = acceptor;
    EXPECT_TRUE(hydrogen_bonds(Molecule(atoms, dimer.bonds(), dimer.positions())).empty())
        << acceptor.element;
  }
  std::vector<Atom> atoms = dimer.atoms();
  atoms[3] = {7, 0, 14};
  EXPECT_FALSE(hydrogen_bonds(Molecule(atoms, dimer.bonds(), dimer.positions())).empty());
}

TEST(HydrogenBonds, CarbonGivesNone) {
  const Molecule dimer = water_dimer(0.28, 109.5);
  std::vector<Atom> atoms = dimer.atoms();
  atoms[0] = {6, 0, 12};
  EXPECT_TRUE(hydrogen_bonds(Molecule(atoms, dimer.bonds(), dimer.positions()), all).empty());
}

TEST(HydrogenBonds, TheStrongestComesFirstAndWeakOnesAreLeftOut) {
  const Molecule three = both(water_dimer(0.30, 109.5), [] {
    const Molecule dimer = water_dimer(0.28, 109.5);
    Positions x = dimer.positions();
    for (Vec3& p : x) p += Vec3(0, 0, 5);
    return Molecule(dimer.atoms(), dimer.bonds(), x);
  }());
  const auto bonds = hydrogen_bonds(three);
  ASSERT_EQ(bonds.size(), 2U);
  EXPECT_EQ(bonds[0].acceptor, 9);
  EXPECT_EQ(bonds[1].acceptor, 3);
  EXPECT_EQ(hydrogen_bonds(three, {.weakest = bonds[1].energy}).size(), 2U);
  EXPECT_EQ(hydrogen_bonds(three, {.weakest = bonds[1].energy - 1e-6}).size(), 1U);
}

TEST(HydrogenBonds, AtomsAtOnePlaceMakeNone) {
  const Molecule dimer = water_dimer(0.28, 109.5);
  EXPECT_TRUE(
      hydrogen_bonds(Molecule(dimer.atoms(), dimer.bonds(), Positions(6, Vec3::Zero())), all)
          .empty());
}

TEST(HydrogenBonds, OptionsThatMakeNoSenseAreRefused) {
  const Molecule dimer = water_dimer(0.28, 109.5);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refusal = [&](const HydrogenBondOptions& options) {
    return refusal_of([&] { hydrogen_bonds(dimer, options); });
  };
  EXPECT_EQ(refusal({.weakest = nan}),
            "the weakest energy and the least angles of hydrogen bonds are to be numbers");
  EXPECT_EQ(refusal({.least_angle_degree = nan}),
            "the weakest energy and the least angles of hydrogen bonds are to be numbers");
  EXPECT_EQ(refusal({.weakest = 1}),
            "the weakest energy of hydrogen bonds is not to be above zero");
  for (const double bad : {nan, 0.0, -1.0})
    EXPECT_EQ(refusal({.usual = {bad, 0.35}}),
              "the reach of hydrogen bonds is to be positive numbers");
}

}  // namespace
}  // namespace ragdoll
