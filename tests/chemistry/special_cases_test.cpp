// What turns, what is flat and what keeps its hand, of molecules that are not run of the mill.

#include <GraphMol/Conformer.h>
#include <gtest/gtest.h>

#include "ragdoll/error.h"
#include "ragdoll/resolver.h"
#include "samples.h"

namespace ragdoll {
namespace {

struct BondCase {
  const char* smiles;
  const char* bond;  ///< SMARTS; its first two atoms
  bool planar;
};

class Bonds : public testing::TestWithParam<BondCase> {};

TEST_P(Bonds, TurnOrDoNot) {
  const auto mol = embedded(GetParam().smiles);
  const std::vector<int> atoms = match(*mol, GetParam().bond);
  ASSERT_GE(atoms.size(), 2U);
  EXPECT_EQ(is_planar(framework_of(*mol), atoms[0], atoms[1]), GetParam().planar)
      << GetParam().smiles << " " << GetParam().bond;
}

INSTANTIATE_TEST_SUITE_P(
    Chemistry, Bonds,
    testing::Values(
        BondCase{"C/C=C/C", "C=C", true}, BondCase{"C/C=N/O", "C=N", true},
        BondCase{"C/N=N\\C", "N=N", true}, BondCase{"C/C=[NH+]/C", "C=N", true},
        BondCase{"C1CCC/C=C/CC1", "C=C", true}, BondCase{"CC(=O)NC", "[#6X3]-[NX3]", true},
        BondCase{"COC(=O)NC", "[#6X3]-[NX3]", true}, BondCase{"CNC(=O)NC", "[#6X3]-[NX3]", true},
        BondCase{"CC(=S)NC", "[#6X3]-[NX3]", true}, BondCase{"CC(=N)NC", "[#6X3]-[NX3]", true},
        BondCase{"CNC(N)=[NH2+]", "[#6X3]-[NX3]", true},
        BondCase{"CNc1ccccn1", "[#6X3]-[NX3]", true}, BondCase{"CNc1ccccc1", "[#6X3]-[NX3]", false},
        BondCase{"CNC=CC", "[#6X3]-[NX3]", false}, BondCase{"CC(=O)OC", "[#6X3]-[OX2]", false},
        BondCase{"CNS(C)(=O)=O", "[#16]-[#7]", false}, BondCase{"C=CC=C", "C-C", false},
        BondCase{"OB(O)c1ccccc1", "c-B", false}, BondCase{"c1ccccc1-c1ccccc1", "c-!:c", false},
        BondCase{"CC(=O)n1cccc1", "[#6X3;!a]-n", false},
        BondCase{"CS(C)(=N)=O", "[#16]=[#7]", false}, BondCase{"CP(C)(C)=CC", "P=C", false}));

struct CentreCase {
  const char* smiles;
  const char* centre;  ///< SMARTS; its first atom
  int chirality, planarity;
};

class CentresOf : public testing::TestWithParam<CentreCase> {};

TEST_P(CentresOf, KeepTheirShape) {
  const auto mol = embedded(GetParam().smiles);
  const std::vector<int> atoms = match(*mol, GetParam().centre);
  ASSERT_FALSE(atoms.empty()) << GetParam().smiles;
  const Framework framework = framework_of(*mol);
  EXPECT_EQ(volumes_about(framework, atoms[0], VolumeKind::chirality), GetParam().chirality)
      << GetParam().smiles;
  if (GetParam().planarity < 0) return;
  EXPECT_EQ(volumes_about(framework, atoms[0], VolumeKind::planarity), GetParam().planarity)
      << GetParam().smiles;
}

INSTANTIATE_TEST_SUITE_P(
    Chemistry, CentresOf,
    testing::Values(CentreCase{"C[S@](=O)CC", "S", 1, 0}, CentreCase{"C[S@+](CC)CCC", "[S+]", 1, 0},
                    CentreCase{"C[P@](CC)c1ccccc1", "P", 1, 0},
                    CentreCase{"C[P@](=O)(O)OC", "P", 1, 0},
                    CentreCase{"C[N@+](CC)(CCC)CCCC", "[N+]", 1, 0},
                    CentreCase{"C[Si@](F)(Cl)CC", "[Si]", 1, 0},
                    CentreCase{"C[S@@](=N)(=O)CC", "S", 1, 0},
                    CentreCase{"OB(O)c1ccccc1", "B", 0, 1}, CentreCase{"C[C+](C)C", "[C+]", 0, 1},
                    CentreCase{"[H][B-](C)(F)CC", "[B-]", 1, 0}, CentreCase{"CC#CC", "C#C", 0, 0},
                    CentreCase{"CC#N", "C#N", 0, 0}, CentreCase{"CN=C=O", "C=O", 0, 0},
                    CentreCase{"C1N2CC1C2", "[#7]", 1, -1}));

TEST(SpecialCases, TheHandOfAnAllene) {
  const auto mol = embedded("CC=C=CCl");
  const Framework framework = framework_of(*mol);
  std::vector<Vec3> mirrored = molecule_from_rdkit(*mol).positions();
  EXPECT_EQ(inverted_centres(framework, mirrored), 0);
  const int centres = framework.chirality_count();
  for (Vec3& x : mirrored) x.z() = -x.z();
  EXPECT_EQ(inverted_centres(framework, mirrored), centres);
  EXPECT_EQ(centres, 1 + 1);  // and the methyl group
}

TEST(SpecialCases, TheHandOfAHinderedBiaryl) {
  // 1,1'-bi-2-naphthol has one, biphenyl and 2-methylbiphenyl turn over
  EXPECT_EQ(framework_of(*embedded("Oc1ccc2ccccc2c1-c1c(O)ccc2ccccc12")).chirality_count(), 1);
  EXPECT_EQ(framework_of(*embedded("Cc1cccc(F)c1-c1ccccc1C")).chirality_count(), 2 + 1);
  EXPECT_EQ(framework_of(*embedded("c1ccccc1-c1ccccc1")).chirality_count(), 0);
  EXPECT_EQ(framework_of(*embedded("Cc1ccccc1-c1ccccc1")).chirality_count(), 1);
}

TEST(SpecialCases, MetalsHaveBarsAndDonorsKeepTheirShape) {
  const auto mol = embedded("CC[N@](C)(CCC)->[Zn]");
  const std::vector<int> atoms = match(*mol, "N->[Zn]");
  ASSERT_EQ(atoms.size(), 2U);
  const Framework framework = framework_of(*mol);
  EXPECT_EQ(volumes_about(framework, atoms[0], VolumeKind::chirality), 1);
  EXPECT_EQ(volumes_about(framework, atoms[1], VolumeKind::chirality), 0);
}

TEST(SpecialCases, EverythingThatEmbedsHasAFramework) {
  std::vector<std::string> refused;
  for (const char* smiles : {"C12C3C4C1C5C2C3C45",
                             "C1CC2CCC1CC2",
                             "C1CCC2(CC1)CCCCC2",
                             "C1CC12CC2",
                             "C1C2CC1C2",
                             "C[CH2]",
                             "[CH3]",
                             "[2H]C([2H])([3H])O",
                             "CN=[N+]=[N-]",
                             "[N-]=[N+]=NC",
                             "CC(C)=C=O",
                             "CN=C=NC",
                             "C=C=C=C",
                             "O=C=O",
                             "CC#CC#CC",
                             "C[Hg]C",
                             "[Na+].[Cl-]",
                             "C[Mg]Br",
                             "Cl[Pt](Cl)(N)N",
                             "C1CCCCCCCCCCCCCCC1",
                             "C[Si](C)(C)C#C",
                             "ClB(Cl)Cl",
                             "CB1OBOBO1",
                             "C[As](C)C",
                             "C[Se]C",
                             "O=I(=O)c1ccccc1",
                             "FI(F)(F)(F)F",
                             "[O-]Cl(=O)(=O)=O",
                             "CS(=O)(=O)C",
                             "C1=CC=CC=CC=C1",
                             "c1ccc2c(c1)ccc1ccccc12",
                             "CC(C)(C)N(O)C(C)(C)C",
                             "O=[N+]([O-])c1ccccc1"}) {
    SCOPED_TRACE(smiles);
    std::shared_ptr<RDKit::RWMol> mol;
    try {
      mol = embedded(smiles);
    } catch (const Error&) {
      refused.push_back(smiles);
      continue;
    }
    const Molecule molecule = molecule_from_rdkit(*mol);
    const Framework framework = build_framework(molecule);
    EXPECT_EQ(inverted_centres(framework, molecule.positions()), 0);
  }
  EXPECT_LE(refused.size(), 2U) << testing::PrintToString(refused);
}

TEST(SpecialCases, AnOctahedronKeepsItsHand) {
  const auto mol = molecule_of_smiles("FS(Cl)(Br)(I)(O)N");
  auto* conformer = new RDKit::Conformer(mol->getNumAtoms());
  conformer->set3D(true);
  // atoms 0 and 2 to 6 about atom 1
  const double places[7][3] = {{1.6, 0, 0},  {0, 0, 0},   {-2, 0, 0},  {0, 2.2, 0},
                               {0, -2.4, 0}, {0, 0, 1.7}, {0, 0, -1.8}};
  for (unsigned int i = 0; i < 7; ++i)
    conformer->setAtomPos(i, RDGeom::Point3D(places[i][0], places[i][1], places[i][2]));
  mol->addConformer(conformer, true);
  const Molecule molecule = molecule_from_rdkit(*mol);
  const Framework framework = build_framework(molecule);
  EXPECT_EQ(framework.chirality_count(), 1);
  std::vector<Vec3> mirrored = molecule.positions();
  for (Vec3& x : mirrored) x.z() = -x.z();
  EXPECT_EQ(inverted_centres(framework, molecule.positions()), 0);
  EXPECT_EQ(inverted_centres(framework, mirrored), 1);
}

}  // namespace
}  // namespace ragdoll
