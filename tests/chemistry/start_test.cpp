#include "ragdoll/chemistry/start.h"

#include <GraphMol/Conformer.h>
#include <GraphMol/MolOps.h>
#include <gtest/gtest.h>

#include "ragdoll/error.h"
#include "samples.h"

namespace ragdoll {
namespace {

TEST(Start, KeepsGivenPlacesAndAddsTheHydrogensThatLack) {
  const auto whole = embedded("CC(O)CN");
  std::unique_ptr<RDKit::ROMol> heavy(
      RDKit::MolOps::removeHs(static_cast<const RDKit::ROMol&>(*whole)));
  const Start start = make_start(*heavy);
  ASSERT_EQ(start.mol->getNumAtoms(), whole->getNumAtoms());
  for (unsigned int i = 0; i < heavy->getNumAtoms(); ++i)
    EXPECT_EQ(
        (start.mol->getConformer().getAtomPos(i) - whole->getConformer().getAtomPos(i)).length(),
        0);
  EXPECT_NO_THROW(framework_of(*start.mol));
}

TEST(Start, EmbedsFlatMoleculesAndTheSameFromTheSameSeed) {
  const auto mol = molecule_of_smiles("OC[C@H](N)Cc1ccccc1");
  const Start one = make_start(*mol, {.seed = 3}), again = make_start(*mol, {.seed = 3});
  const Start other = make_start(*mol, {.seed = 4});
  double apart = 0;
  for (unsigned int i = 0; i < one.mol->getNumAtoms(); ++i) {
    const auto& p = one.mol->getConformer().getAtomPos(i);
    EXPECT_EQ((p - again.mol->getConformer().getAtomPos(i)).length(), 0);
    apart += (p - other.mol->getConformer().getAtomPos(i)).length();
  }
  EXPECT_GT(apart, 0.1);
  EXPECT_TRUE(one.notes.empty());
}

TEST(Start, PutsFragmentsSideBySide) {
  const Start start = make_start(*molecule_of_smiles("CCO.[Na+].[Cl-]"));
  const auto& conformer = start.mol->getConformer();
  EXPECT_GT((conformer.getAtomPos(3) - conformer.getAtomPos(4)).length(), 2);
  EXPECT_GT((conformer.getAtomPos(0) - conformer.getAtomPos(3)).length(), 2);
}

TEST(Start, IsRefusedForDummiesAndForAtomsInOnePlace) {
  EXPECT_THROW(make_start(*molecule_of_smiles("*CC")), Error);
  const auto mol = embedded("CCO");
  mol->getConformer().getAtomPos(1) = mol->getConformer().getAtomPos(0);
  mol->getConformer().getAtomPos(1).x += 0.01;
  EXPECT_THROW(make_start(*mol), Error);
}

}  // namespace
}  // namespace ragdoll
