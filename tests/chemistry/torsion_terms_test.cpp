#include "ragdoll/chemistry/torsion_terms.h"

#include <GraphMol/MolOps.h>
#include <GraphMol/ROMol.h>
#include <GraphMol/SmilesParse/SmilesParse.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <set>
#include <string>
#include <utility>

namespace ragdoll {
namespace {

std::unique_ptr<RDKit::ROMol> with_hydrogens(const std::string& smiles) {
  const std::unique_ptr<RDKit::ROMol> mol(RDKit::SmilesToMol(smiles));
  return std::unique_ptr<RDKit::ROMol>(RDKit::MolOps::addHs(*mol));
}

double energy(const TorsionTerm& term, double degree) {
  double sum = 0;
  for (std::size_t k = 0; k < 6; ++k)
    sum += term.amplitude[k] *
           (1 + term.sign[k] * std::cos(double(k + 1) * degree * std::numbers::pi / 180));
  return sum;
}

TEST(TorsionTerms, PreferTheAmideTrans) {
  const auto terms = torsion_terms(*with_hydrogens("CC(=O)NC"));
  ASSERT_EQ(terms.size(), 1U);
  // O=C-N-C: cis to oxygen is trans to the methyl
  EXPECT_EQ(terms[0].b + terms[0].c, 1 + 3);
  EXPECT_LT(energy(terms[0], 0) + 10, energy(terms[0], 180));
  EXPECT_LT(energy(terms[0], 0) + 10, energy(terms[0], 90));
}

TEST(TorsionTerms, StaggerAChain) {
  const auto terms = torsion_terms(*with_hydrogens("CCCC"));
  ASSERT_EQ(terms.size(), 1U);
  EXPECT_LT(energy(terms[0], 180), energy(terms[0], 120));
  EXPECT_LT(energy(terms[0], 60), energy(terms[0], 0));
}

TEST(TorsionTerms, AreAtMostOneABond) {
  const auto mol = with_hydrogens("CC(=O)Oc1ccccc1C(=O)NCCCS(=O)(=O)N1CCOCC1");
  std::set<std::pair<int, int>> seen;
  for (const TorsionTerm& term : torsion_terms(*mol)) {
    EXPECT_TRUE(seen.insert(std::minmax(term.b, term.c)).second);
    EXPECT_TRUE(mol->getBondBetweenAtoms(unsigned(term.b), unsigned(term.c)));
  }
  EXPECT_GE(seen.size(), 6U);
}

TEST(TorsionTerms, OfRingsAreThereWhenAsked) {
  const auto hexane = with_hydrogens("C1CCCCC1");
  EXPECT_EQ(torsion_terms(*hexane).size(), 0U);
  EXPECT_EQ(torsion_terms(*hexane, {.small_rings = true, .macrocycles = true}).size(), 6U);
  const auto large = with_hydrogens("C1CCCCCCCCCCC1");
  EXPECT_EQ(torsion_terms(*large).size(), 12U);
  EXPECT_EQ(torsion_terms(*large, {.small_rings = false, .macrocycles = false}).size(), 0U);
}

TEST(TorsionTerms, OfAMoleculeWithoutTorsionsAreNone) {
  EXPECT_TRUE(torsion_terms(*with_hydrogens("C")).empty());
}

}  // namespace
}  // namespace ragdoll
