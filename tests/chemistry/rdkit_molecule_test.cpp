#include "ragdoll/chemistry/rdkit_molecule.h"

#include <GraphMol/Conformer.h>
#include <gtest/gtest.h>

#include <limits>

#include "ragdoll/error.h"
#include "samples.h"

namespace ragdoll {
namespace {

/// The sentence that a molecule is refused with.
std::string refusal(const RDKit::ROMol& mol, int conformer = -1) {
  try {
    molecule_from_rdkit(mol, conformer);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(RdkitMolecule, HasAtomsChargesOrdersAndPlacesInNanometers) {
  const auto mol = embedded("CC(=O)Oc1ccccc1C(=O)[O-]");
  const Molecule molecule = molecule_from_rdkit(*mol);
  ASSERT_EQ(molecule.atoms().size(), mol->getNumAtoms());
  std::vector<int> orders(6);
  for (const Bond& bond : molecule.bonds()) {
    ++orders[std::size_t(bond.order)];
    EXPECT_LT(bond.a, bond.b);
  }
  EXPECT_EQ(orders, (std::vector<int>{0, 12, 2, 0, 6, 0}));
  int charge = 0;
  for (const Atom& atom : molecule.atoms()) charge += atom.formal_charge;
  EXPECT_EQ(charge, -1);
  EXPECT_EQ(molecule.atoms()[0].label, "C1 LIG1 A");
  for (unsigned int i = 0; i < mol->getNumAtoms(); ++i)
    EXPECT_NEAR(molecule.positions()[i].x(), mol->getConformer().getAtomPos(i).x / 10, 1e-9);
}

TEST(RdkitMolecule, IsotopesHaveTheirOwnMass) {
  const Molecule molecule = molecule_from_rdkit(*embedded("[2H]C([2H])([2H])[13CH2]O"));
  EXPECT_NEAR(molecule.atoms()[0].mass, 2.0141, 1e-4);
  EXPECT_NEAR(molecule.atoms()[1].mass, 12.011, 1e-3);
  EXPECT_NEAR(molecule.atoms()[4].mass, 13.0034, 1e-4);
  EXPECT_EQ(molecule.atoms()[0].element, 1);
}

TEST(RdkitMolecule, ZeroOrderAndDativeBondsAreOneKind) {
  const auto mol = embedded("CN->[Zn]");
  bool found = false;
  const Molecule molecule = molecule_from_rdkit(*mol);
  for (const Bond& bond : molecule.bonds()) found = found || bond.order == BondOrder::dative;
  EXPECT_TRUE(found);
}

TEST(RdkitMolecule, IsRefusedWithoutAConformerInThreeDimensions) {
  const auto mol = embedded("CCO");
  EXPECT_NE(refusal(*mol, 3).find("no conformer 3"), std::string::npos);
  mol->setProp("_Name", std::string("ethanol"));
  mol->getConformer().set3D(false);
  EXPECT_NE(refusal(*mol).find("ethanol has a flat conformer"), std::string::npos);
  mol->clearConformers();
  EXPECT_NE(refusal(*mol).find("embed it"), std::string::npos);
}

TEST(RdkitMolecule, IsRefusedWithPlacesThatAreNoNumbers) {
  const auto mol = embedded("CCO");
  mol->getConformer().getAtomPos(1).y = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(refusal(*mol).find("C2 LIG1 A has no usable place"), std::string::npos);
}

TEST(RdkitMolecule, PositionsComeBackAsAConformer) {
  const auto mol = embedded("CCO");
  const Molecule molecule = molecule_from_rdkit(*mol);
  const unsigned int id = add_conformer(*mol, molecule.positions());
  EXPECT_EQ(mol->getNumConformers(), 2U);
  for (unsigned int i = 0; i < mol->getNumAtoms(); ++i)
    EXPECT_LT(
        (mol->getConformer(int(id)).getAtomPos(i) - mol->getConformer(0).getAtomPos(i)).length(),
        1e-8);
  EXPECT_THROW(add_conformer(*mol, std::span(molecule.positions()).first(2)), Error);
}

}  // namespace
}  // namespace ragdoll
