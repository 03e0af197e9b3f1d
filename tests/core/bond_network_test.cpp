// Tests for core/src/bond_network.cpp.

#include "ragdoll/bond_network.h"

#include <gtest/gtest.h>

#include <algorithm>  // count

#include "examples.h"
#include "molecules.h"

namespace ragdoll {
namespace {

using namespace examples;

int count_of(const Molecule& molecule, BondLock lock) {
  const std::vector<BondLock> locks = bond_locks(molecule);
  return int(std::count(locks.begin(), locks.end(), lock));
}

Rigidity rigidity_of(const Molecule& molecule, const BondNetworkOptions& options = {}) {
  return analyse_rigidity(build_bond_network(molecule, {}, {}, options).network);
}

/// C 0 with NH2 1 and NH2 2 and N 3 that has H 8 and a methyl C 9; one bond is written double.
Molecule guanidinium() {
  std::vector<Atom> atoms = {{6, 0, 12}, {7, 0, 14}, {7, 1, 14}, {7, 0, 14}};
  std::vector<Bond> bonds = {{0, 1}, {0, 2, BondOrder::double_bond}, {0, 3}};
  for (const int nitrogen : {1, 1, 2, 2, 3}) {
    bonds.push_back({nitrogen, int(atoms.size())});
    atoms.push_back({1, 0, 1});
  }
  bonds.push_back({3, 9});
  atoms.push_back({6, 0, 12});
  Random random(8, RandomStream::generate, 0);
  const Positions x = random_points(int(atoms.size()), 1, random);
  return Molecule(std::move(atoms), std::move(bonds), x);
}

TEST(BondNetwork, APeptideBondIsLockedAndAPrimaryAmideIsNot) {
  const std::vector<BondLock> peptide = bond_locks(methylacetamide());
  EXPECT_EQ(peptide[1], BondLock::peptide);
  EXPECT_EQ(count_of(methylacetamide(), BondLock::none), int(peptide.size()) - 1);
  EXPECT_EQ(count_of(formamide(), BondLock::primary_amide), 1);
  // methyls turn, and so does NH2
  EXPECT_EQ(rigidity_of(methylacetamide()).floppy_modes, 2);
  EXPECT_EQ(rigidity_of(formamide()).floppy_modes, 1);
}

TEST(BondNetwork, WhatIsLockedIsAnOption) {
  BondNetworkOptions options;
  options.locks[std::size_t(BondLock::peptide)] = false;
  options.locks[std::size_t(BondLock::primary_amide)] = true;
  EXPECT_EQ(rigidity_of(methylacetamide(), options).floppy_modes, 3);
  EXPECT_EQ(rigidity_of(formamide(), options).floppy_modes, 0);
  EXPECT_EQ(build_bond_network(formamide(), {}, {}, options).locked_bonds, 1);
  EXPECT_EQ(build_bond_network(formamide(), {}, {}).locked_bonds, 0);
}

TEST(BondNetwork, AllBondsOfAGuanidiniumToItsCarbonAreLocked) {
  const std::vector<BondLock> locks = bond_locks(guanidinium());
  for (const std::size_t bond : {0U, 1U, 2U}) EXPECT_EQ(locks[bond], BondLock::guanidinium);
  EXPECT_EQ(count_of(guanidinium(), BondLock::none), 6);
  EXPECT_EQ(rigidity_of(guanidinium()).floppy_modes, 0);
}

TEST(BondNetwork, AromaticRingsAndMultipleBondsAreLocked) {
  EXPECT_EQ(count_of(benzene(), BondLock::aromatic), 6);
  const Rigidity r = rigidity_of(benzene());
  EXPECT_EQ(r.cluster_sizes, std::vector<int>{12});
  EXPECT_EQ(r.region_sizes, std::vector<int>{6});
  EXPECT_EQ(count_of(allene(), BondLock::multiple), 2);
  EXPECT_EQ(count_of(acetylene(), BondLock::multiple), 1);
  EXPECT_EQ(rigidity_of(allene()).floppy_modes, 0);
}

TEST(BondNetwork, ACarbonylIsNoLockedBondForItsOxygenIsBondedOnce) {
  for (const Molecule& molecule : {formamide(), methylacetamide()})
    EXPECT_EQ(count_of(molecule, BondLock::multiple), 0);
}

TEST(BondNetwork, SingleBondsTurn) {
  EXPECT_EQ(rigidity_of(ethane()).floppy_modes, 1);
  EXPECT_EQ(rigidity_of(heptane()).floppy_modes, 6);
  // an envelope of five is rigid with one bar too many
  EXPECT_EQ(rigidity_of(cyclopentane_ring()).floppy_modes, 0);
  EXPECT_EQ(rigidity_of(cyclopentane_ring()).redundant_bars, 1);
}

TEST(BondNetwork, CovalentBondsComeFirstThenTethersThenHydrogenBonds) {
  const Molecule molecule = heptane();
  const HydrophobicTether tether = {0, 5, 0.3, 0.39};
  HydrogenBond bond;
  bond.donor = 2;
  bond.hydrogen = 9;
  bond.acceptor = 4;
  BondNetworkOptions options;
  options.tether_bars = 3;
  options.hydrogen_bond_bars = 4;
  const BondNetwork built =
      build_bond_network(molecule, std::vector{tether}, std::vector{bond}, options);
  EXPECT_EQ(built.network.bodies, int(molecule.atoms().size()));
  EXPECT_EQ(built.covalent_bonds, int(molecule.bonds().size()));
  EXPECT_EQ(built.tethers, 1);
  EXPECT_EQ(built.hydrogen_bonds, 1);
  const auto& bonds = built.network.bonds;
  ASSERT_EQ(bonds.size(), molecule.bonds().size() + 2);
  for (std::size_t k = 0; k < molecule.bonds().size(); ++k) {
    EXPECT_EQ(bonds[k].a, molecule.bonds()[k].a);
    EXPECT_EQ(bonds[k].b, molecule.bonds()[k].b);
    EXPECT_EQ(bonds[k].bars, 5);
  }
  const BodyBond &second_last = bonds[bonds.size() - 2], &last = bonds.back();
  EXPECT_EQ(std::tuple(second_last.a, second_last.b, second_last.bars), std::tuple(0, 5, 3));
  EXPECT_EQ(std::tuple(last.a, last.b, last.bars), std::tuple(9, 4, 4));
}

TEST(BondNetwork, BarsOutOfRangeAreRefused) {
  for (const int bars : {0, 7}) {
    const std::string end = " are 1 to 6, not " + std::to_string(bars);
    EXPECT_EQ(
        refusal_of([&] { build_bond_network(ethane(), {}, {}, {.hydrogen_bond_bars = bars}); }),
        "the bars of a hydrogen bond" + end);
    EXPECT_EQ(refusal_of([&] { build_bond_network(ethane(), {}, {}, {.tether_bars = bars}); }),
              "the bars of a tether" + end);
  }
}

}  // namespace
}  // namespace ragdoll
