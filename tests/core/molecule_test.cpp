// Tests for core/src/molecule.cpp.

#include "ragdoll/molecule.h"

#include <gtest/gtest.h>

#include <limits>

#include "examples.h"

namespace ragdoll {
namespace {

using examples::Positions;
using examples::refusal_of;

const std::vector<Atom> water_atoms = {{8, 0, 16, "O HOH1"}, {1, 0, 1, ""}, {1, 0, 1, "H2 HOH1"}};
const std::vector<Bond> water_bonds = {{0, 1, BondOrder::single}, {2, 0, BondOrder::single}};
const Positions water_positions = {{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}};

std::string refusal(std::vector<Atom> atoms, std::vector<Bond> bonds, Positions positions) {
  return refusal_of([&] { Molecule(atoms, bonds, positions); });
}

TEST(Molecule, NeighboursComeInTheOrderOfTheBonds) {
  const Molecule water(water_atoms, water_bonds, water_positions);
  ASSERT_EQ(water.neighbours(0).size(), 2U);
  EXPECT_EQ(water.neighbours(0)[0].atom, 1);
  EXPECT_EQ(water.neighbours(0)[1].atom, 2);
  EXPECT_EQ(water.neighbours(0)[1].bond, 1);
  ASSERT_EQ(water.neighbours(2).size(), 1U);
  EXPECT_EQ(water.neighbours(2)[0].atom, 0);
}

TEST(Molecule, AtomsWithoutALabelAreNumbered) {
  const Molecule water(water_atoms, water_bonds, water_positions);
  EXPECT_EQ(water.name(0), "O HOH1");
  EXPECT_EQ(water.name(1), "atom 1");
}

TEST(Molecule, NoAtomsAreRefused) {
  EXPECT_EQ(refusal({}, {}, {}), "the molecule has no atoms");
}

TEST(Molecule, SizesThatDisagreeAreRefused) {
  EXPECT_EQ(refusal(water_atoms, {}, {Vec3::Zero()}), "the molecule has 3 atoms but 1 positions");
}

TEST(Molecule, BondToAnUnknownAtomIsRefused) {
  for (const int atom : {-1, 3}) {
    const std::string sentence = "bond 1 names an atom that the molecule does not have";
    EXPECT_EQ(refusal(water_atoms, {{0, 1}, {0, atom}}, water_positions), sentence);
    EXPECT_EQ(refusal(water_atoms, {{0, 1}, {atom, 0}}, water_positions), sentence);
  }
}

TEST(Molecule, BondFromAnAtomToItselfIsRefused) {
  EXPECT_EQ(refusal(water_atoms, {{2, 2}}, water_positions), "a bond joins H2 HOH1 to itself");
}

TEST(Molecule, TwoBondsOnOnePairAreRefusedEitherWayRound) {
  EXPECT_EQ(refusal(water_atoms, {{0, 1}, {0, 1}}, water_positions),
            "two bonds join O HOH1 and atom 1");
  EXPECT_NE(refusal(water_atoms, {{0, 1}, {1, 0}}, water_positions), "");
}

TEST(Molecule, CoordinateThatIsNotFiniteIsRefusedByName) {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    Positions positions = water_positions;
    positions[2][1] = bad;
    EXPECT_EQ(refusal(water_atoms, water_bonds, positions),
              "a coordinate of H2 HOH1 is not a finite number");
  }
}

}  // namespace
}  // namespace ragdoll
