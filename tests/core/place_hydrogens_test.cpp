// Tests for core/src/place_hydrogens.cpp and aromatic_hydrogens.cpp.

#include "ragdoll/place_hydrogens.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>  // AngleAxisd
#include <cmath>           // acos, cos, sin
#include <map>
#include <numbers>  // pi

#include "examples.h"
#include "molecules.h"
#include "peptides.h"

namespace ragdoll {
namespace {

using namespace examples;

constexpr double degree = std::numbers::pi / 180;

/// Without its hydrogens.
Molecule heavy_atoms_of(const Molecule& molecule) {
  std::vector<Atom> atoms;
  std::vector<Bond> bonds;
  Positions x;
  std::vector<int> number(molecule.atoms().size(), -1);
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (molecule.atoms()[i].element == 1) continue;
    number[i] = int(atoms.size());
    atoms.push_back(molecule.atoms()[i]);
    x.push_back(molecule.positions()[i]);
  }
  for (const Bond& bond : molecule.bonds())
    if (number[std::size_t(bond.a)] >= 0 && number[std::size_t(bond.b)] >= 0)
      bonds.push_back({number[std::size_t(bond.a)], number[std::size_t(bond.b)], bond.order});
  return Molecule(atoms, bonds, x);
}

/// Hydrogens placed on each atom.
std::map<int, int> hydrogens_of(const Molecule& molecule) {
  const Molecule placed = place_hydrogens(molecule);
  std::map<int, int> count;
  for (std::size_t k = molecule.bonds().size(); k < placed.bonds().size(); ++k)
    ++count[placed.bonds()[k].a];
  return count;
}

/// A flat ring of atoms, each with what hangs on it (0: nothing), all ring bonds aromatic. Ring
/// atoms come first.
Molecule ring(const std::vector<int>& elements, const std::vector<std::pair<int, bool>>& outside) {
  std::vector<Atom> atoms;
  std::vector<Bond> bonds;
  Positions x;
  const int n = int(elements.size());
  const double radius = 0.07 / std::sin(std::numbers::pi / n);
  const auto at = [&](int k, double r) {
    return Vec3(r * std::cos(2 * std::numbers::pi * k / n),
                r * std::sin(2 * std::numbers::pi * k / n), 0);
  };
  for (int k = 0; k < n; ++k) {
    atoms.push_back({elements[std::size_t(k)], 0, 12});
    x.push_back(at(k, radius));
    bonds.push_back({k, (k + 1) % n, BondOrder::aromatic});
  }
  for (int k = 0; k < n; ++k) {
    const auto [element, is_double] = outside[std::size_t(k)];
    if (element == 0) continue;
    bonds.push_back({k, int(atoms.size()), is_double ? BondOrder::double_bond : BondOrder::single});
    atoms.push_back({element, 0, 12});
    x.push_back(at(k, radius + 0.14));
  }
  return Molecule(atoms, bonds, x);
}

TEST(PlaceHydrogens, AnAmideHasThemWhereTheyWere) {
  const Molecule whole = formamide(), placed = place_hydrogens(heavy_atoms_of(whole));
  ASSERT_EQ(placed.atoms().size(), 5U);
  for (const std::size_t h : {3U, 4U}) {
    EXPECT_EQ(placed.atoms()[h].element, 1);
    const double distance = std::min((placed.positions()[h] - whole.positions()[4]).norm(),
                                     (placed.positions()[h] - whole.positions()[5]).norm());
    EXPECT_LT(distance, 1e-3);
  }
}

TEST(PlaceHydrogens, ABackboneHasOneOnEachNitrogenAcrossFromTheCarbonyl) {
  const Molecule chain = alanines({{-63, -42}, {-120, 135}});
  const Molecule placed = place_hydrogens(chain);
  ASSERT_EQ(placed.atoms().size(), chain.atoms().size() + 3);
  for (std::size_t k = chain.atoms().size(); k < placed.atoms().size(); ++k) {
    const int nitrogen = placed.neighbours(int(k)).front().atom;
    const Vec3 h = placed.positions()[k] - placed.positions()[std::size_t(nitrogen)];
    EXPECT_NEAR(h.norm(), 0.101, 1e-9);
    const int carbon = placed.neighbours(nitrogen).front().atom;
    int oxygen = -1;
    for (const auto& [other, bond] : placed.neighbours(carbon))
      if (placed.atoms()[std::size_t(other)].element == 8) oxygen = other;
    const Vec3 co =
        placed.positions()[std::size_t(oxygen)] - placed.positions()[std::size_t(carbon)];
    EXPECT_LT(h.normalized().dot(co.normalized()), -0.95);
  }
}

TEST(PlaceHydrogens, AHydroxylTurnsToTheAcceptor) {
  // a methanol without hydrogens, and a formaldehyde's O beside its O, off in some direction
  for (const double turn : {0.0, 70.0, 200.0}) {
    const Vec3 donor(0.143, 0, 0);
    const Vec3 to(std::cos(70.5 * degree), std::sin(70.5 * degree) * std::cos(turn * degree),
                  std::sin(70.5 * degree) * std::sin(turn * degree));
    const Vec3 acceptor = donor + 0.28 * to;
    const Molecule molecule({{6, 0, 12}, {8, 0, 16}, {8, 0, 16}, {6, 0, 12}},
                            {{0, 1, BondOrder::single}, {2, 3, BondOrder::double_bond}},
                            {{0, 0, 0}, donor, acceptor, acceptor + 0.122 * to});
    const Molecule placed = place_hydrogens(molecule);
    ASSERT_EQ(placed.atoms().size(), 5U);
    const Vec3 h = placed.positions()[4] - donor;
    EXPECT_GT(h.normalized().dot(to), std::cos(8 * degree)) << turn;
    EXPECT_NEAR(h.normalized().dot(Vec3(-1, 0, 0)), std::cos(109.5 * degree), 0.01);
  }
}

TEST(PlaceHydrogens, ChargesAndValencesTellHowMany) {
  const auto on_carbon = [](int element, int charge) {
    return Molecule({{6, 0, 12}, {element, charge, 14}}, {{0, 1, BondOrder::single}},
                    {{0, 0, 0}, {0.147, 0, 0}});
  };
  EXPECT_EQ(hydrogens_of(on_carbon(7, 1))[1], 3);
  EXPECT_EQ(hydrogens_of(on_carbon(7, 0))[1], 2);
  EXPECT_EQ(hydrogens_of(on_carbon(8, 0))[1], 1);
  EXPECT_EQ(hydrogens_of(on_carbon(8, -1))[1], 0);
  EXPECT_EQ(hydrogens_of(on_carbon(16, 0))[1], 1);
  EXPECT_EQ(hydrogens_of(on_carbon(6, 0))[1], 0);
}

TEST(PlaceHydrogens, AnAmmoniumIsATetrahedron) {
  const Molecule placed = place_hydrogens(
      Molecule({{6, 0, 12}, {7, 1, 14}}, {{0, 1, BondOrder::single}}, {{0, 0, 0}, {0.147, 0, 0}}));
  ASSERT_EQ(placed.atoms().size(), 5U);
  const auto direction = [&](std::size_t k) {
    return (placed.positions()[k] - placed.positions()[1]).normalized();
  };
  for (const std::size_t a : {0U, 2U, 3U, 4U})
    for (const std::size_t b : {0U, 2U, 3U, 4U})
      if (a < b) {
        EXPECT_NEAR(direction(a).dot(direction(b)), -1.0 / 3, 0.01);
      }
}

TEST(PlaceHydrogens, AromaticNitrogensHaveThoseThatTheirRingsNeed) {
  const std::pair<int, bool> nothing = {0, false}, carbonyl = {8, true}, methyl = {6, false};
  // pyrrole and pyridine
  EXPECT_EQ(hydrogens_of(ring({7, 6, 6, 6, 6}, {nothing, nothing, nothing, nothing, nothing})),
            (std::map<int, int>{{0, 1}}));
  EXPECT_TRUE(hydrogens_of(ring({7, 6, 6, 6, 6, 6}, std::vector(6, nothing))).empty());
  // an imidazole has one of its two; where nothing binds it is the later
  EXPECT_EQ(hydrogens_of(ring({7, 6, 7, 6, 6}, std::vector(5, nothing))),
            (std::map<int, int>{{2, 1}}));
  // a nitrogen with three neighbours needs none, nor does the other one then
  EXPECT_TRUE(
      hydrogens_of(ring({7, 6, 7, 6, 6}, {methyl, nothing, nothing, nothing, nothing})).empty());
  // uracil's N3 lies between two carbonyls; N1 has a sugar
  EXPECT_EQ(hydrogens_of(
                ring({7, 6, 7, 6, 6, 6}, {methyl, carbonyl, nothing, carbonyl, nothing, nothing})),
            (std::map<int, int>{{2, 1}}));
  // cytosine's N3 has a double bond, and its amino group two hydrogens
  EXPECT_EQ(hydrogens_of(ring({7, 6, 7, 6, 6, 6},
                              {methyl, carbonyl, nothing, {7, false}, nothing, nothing})),
            (std::map<int, int>{{8, 2}}));
}

TEST(PlaceHydrogens, AnImidazoleBindsWhereItBondsMoreStrongly) {
  const std::pair<int, bool> nothing = {0, false};
  for (const int nitrogen : {0, 2}) {
    const Molecule alone = ring({7, 6, 7, 6, 6}, std::vector(5, nothing));
    std::vector<Atom> atoms = alone.atoms();
    std::vector<Bond> bonds = alone.bonds();
    Positions x = alone.positions();
    const Vec3 out = x[std::size_t(nitrogen)].normalized();
    atoms.push_back({8, 0, 16});
    atoms.push_back({6, 0, 12});
    bonds.push_back({5, 6, BondOrder::double_bond});
    x.push_back(x[std::size_t(nitrogen)] + 0.28 * out);
    x.push_back(x[std::size_t(nitrogen)] + 0.40 * out);
    EXPECT_EQ(hydrogens_of(Molecule(atoms, bonds, x)), (std::map<int, int>{{nitrogen, 1}}));
  }
}

TEST(PlaceHydrogens, PartsThatHaveThemAndWatersAndUnknownBondsAreLeftAlone) {
  EXPECT_EQ(place_hydrogens(formamide()).atoms().size(), 6U);
  EXPECT_EQ(place_hydrogens(ammonia()).atoms().size(), 4U);
  const Molecule waters = loose_atoms({8, 8}, {{0, 0, 0}, {0.28, 0, 0}});
  EXPECT_EQ(place_hydrogens(waters).atoms().size(), 2U);
  const Molecule unknown({{6, 0, 12}, {8, 0, 16}}, {{0, 1}}, {{0, 0, 0}, {0.143, 0, 0}});
  EXPECT_EQ(place_hydrogens(unknown).atoms().size(), 2U);
}

}  // namespace
}  // namespace ragdoll
