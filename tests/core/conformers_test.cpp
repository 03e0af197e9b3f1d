// Tests for core/src/conformers.cpp and what it is made of.

#include "ragdoll/conformers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "diverse_choice.h"
#include "examples.h"  // refusal_of
#include "graph_symmetry.h"
#include "molecules.h"
#include "part_tree.h"
#include "ragdoll/random.h"
#include "ragdoll/superposition.h"
#include "ring_torsions.h"  // torsion_of
#include "torsion_table.h"

namespace ragdoll {
namespace {

using examples::refusal_of;

Conformers conformers_of(const Molecule& molecule, const ConformerSettings& settings,
                         std::span<const TorsionTerm> terms = {}) {
  return sample_conformers(molecule, terms, settings);
}

double torsion_in(const std::vector<Vec3>& x, int a, int b, int c, int d) {
  return torsion_of(x[std::size_t(a)], x[std::size_t(b)], x[std::size_t(c)], x[std::size_t(d)]);
}

/// Bonds between two atoms; 99 where there is no way.
int bonds_between(const Molecule& molecule, int from, int to) {
  std::vector<int> distance(molecule.atoms().size(), 99), queue = {from};
  distance[std::size_t(from)] = 0;
  for (std::size_t k = 0; k < queue.size(); ++k)
    for (const auto& [other, bond] : molecule.neighbours(queue[k]))
      if (distance[std::size_t(other)] == 99) {
        distance[std::size_t(other)] = distance[std::size_t(queue[k])] + 1;
        queue.push_back(other);
      }
  return distance[std::size_t(to)];
}

std::vector<Vec3> heavy_places(const Molecule& molecule, const std::vector<Vec3>& x) {
  std::vector<Vec3> heavy;
  for (std::size_t i = 0; i < x.size(); ++i)
    if (molecule.atoms()[i].element != 1) heavy.push_back(x[i]);
  return heavy;
}

/// A chain that is the other way round is the same.
double heptane_rmsd(const std::vector<Vec3>& a, std::vector<Vec3> b) {
  const double forward = superposed_rmsd(a, b);
  std::reverse(b.begin(), b.end());
  return std::min(forward, superposed_rmsd(a, b));
}

TEST(Conformers, AsManyAreDeliveredAsAreAsked) {
  for (const int count : {1, 7, 50, 450})
    EXPECT_EQ(conformers_of(examples::heptane(), {.count = count}).positions.size(),
              std::size_t(count));
}

TEST(Conformers, BondLengthsAndAnglesAreThoseOfTheStart) {
  const Molecule molecule = examples::heptane();
  const std::vector<Vec3>& start = molecule.positions();
  for (const std::vector<Vec3>& x : conformers_of(molecule, {.count = 20}).positions)
    for (std::size_t i = 0; i < x.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        if (bonds_between(molecule, int(i), int(j)) > 2) continue;
        EXPECT_NEAR((x[i] - x[j]).norm(), (start[i] - start[j]).norm(), 1e-9);
      }
}

TEST(Conformers, CentresKeepTheirHand) {
  const Molecule molecule = examples::heptane();
  const std::vector<Vec3>& start = molecule.positions();
  for (const std::vector<Vec3>& x : conformers_of(molecule, {.count = 20}).positions)
    for (int i = 0; i < int(x.size()); ++i) {
      const auto& n = molecule.neighbours(i);
      if (n.size() != 4) continue;
      const auto volume = [&](const std::vector<Vec3>& y) {
        return signed_volume(y[std::size_t(n[0].atom)], y[std::size_t(n[1].atom)],
                             y[std::size_t(n[2].atom)], y[std::size_t(n[3].atom)]);
      };
      EXPECT_NEAR(volume(x), volume(start), 1e-9);
    }
}

TEST(Conformers, AtomsFarAlongTheChainStayApart) {
  const Molecule molecule = examples::heptane();
  for (const std::vector<Vec3>& x : conformers_of(molecule, {.count = 200}).positions)
    for (int i = 0; i < int(x.size()); ++i)
      for (int j = 0; j < i; ++j) {
        if (bonds_between(molecule, i, j) <= 3) continue;
        EXPECT_GT((x[std::size_t(i)] - x[std::size_t(j)]).norm(), 0.165);
      }
}

TEST(Conformers, TheChainIsFoundStretchedAndFolded) {
  double longest = 0, shortest = 1;
  for (const std::vector<Vec3>& x : conformers_of(examples::heptane(), {.count = 30}).positions) {
    longest = std::max(longest, (x[0] - x[6]).norm());
    shortest = std::min(shortest, (x[0] - x[6]).norm());
  }
  EXPECT_GT(longest, 0.72);
  EXPECT_LT(shortest, 0.55);
}

TEST(Conformers, TorsionsFollowTheirTerms) {
  const Molecule molecule = examples::heptane();
  std::vector<TorsionTerm> terms;
  for (int c = 0; c < 4; ++c) {
    TorsionTerm& term = terms.emplace_back(TorsionTerm{c, c + 1, c + 2, c + 3, {}, {}});
    term.amplitude[0] = 250;             // a quarter of it counts
    term.sign[0] = c % 2 == 0 ? 1 : -1;  // likes 180 degrees, or 0
  }
  for (const int c : {0, 2})
    for (const std::vector<Vec3>& x :
         conformers_of(molecule, {.count = 20}, std::span(terms).subspan(std::size_t(c), 1))
             .positions)
      EXPECT_LT(std::cos(torsion_in(x, c, c + 1, c + 2, c + 3)), -0.5);
}

TEST(Conformers, TheScoreIsThatOfTheTerms) {
  // rules hold for the other bonds: two runs differ by the one term's energy alone
  TorsionTerm term{0, 1, 2, 3, {}, {}};
  term.amplitude = {3, 0, 5, 0, 0, 0};
  term.sign = {1, 0, -1, 0, 0, 0};
  EXPECT_NEAR(energy_of(term, 0), 6, 1e-12);
  EXPECT_NEAR(energy_of(term, std::numbers::pi), 10, 1e-12);
  EXPECT_NEAR(energy_of(term, std::numbers::pi / 2), 3 + 5, 1e-12);
}

TEST(Conformers, SecondaryAmidesKeepTheirSide) {
  for (const double omega : {180.0, 0.0})
    for (const std::vector<Vec3>& x :
         conformers_of(examples::methylacetamide(omega), {.count = 30}).positions)
      EXPECT_GT(std::cos(torsion_in(x, 3, 0, 2, 4)) * std::cos(omega * std::numbers::pi / 180),
                0.7);
}

TEST(Conformers, TheSameSeedGivesTheSameConformersAndAnotherOneOthers) {
  const Molecule molecule = examples::heptane();
  const auto run = [&](std::uint64_t seed) {
    return conformers_of(molecule, {.count = 10, .seed = seed}).positions;
  };
  EXPECT_EQ(run(3), run(3));
  EXPECT_NE(run(3), run(4));
}

TEST(Conformers, PrunedOnesAreApart) {
  const Molecule molecule = examples::heptane();
  const Conformers found = conformers_of(molecule, {.count = 12, .prune_rmsd = 0.05});
  ASSERT_EQ(found.positions.size(), 12u);
  for (std::size_t i = 0; i < 12; ++i)
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_GT(heptane_rmsd(heavy_places(molecule, found.positions[i]),
                             heavy_places(molecule, found.positions[j])),
                0.0499);
}

TEST(Conformers, WhereThereAreFewerTheReasonIsSaid) {
  const Conformers found = conformers_of(examples::heptane(), {.count = 100, .prune_rmsd = 0.08});
  EXPECT_LT(found.positions.size(), 100u);
  EXPECT_GT(found.positions.size(), 1u);
  EXPECT_NE(found.reason.find("apart"), std::string::npos) << found.reason;
  EXPECT_EQ(conformers_of(examples::heptane(), {.count = 10}).reason, "");
}

TEST(Conformers, ARigidMoleculeIsRepeatedUnlessPruned) {
  EXPECT_EQ(conformers_of(examples::benzene(), {.count = 5}).positions.size(), 5u);
  const Conformers one = conformers_of(examples::benzene(), {.count = 5, .prune_rmsd = 0.01});
  EXPECT_EQ(one.positions.size(), 1u);
  EXPECT_NE(one.reason.find("rigid"), std::string::npos) << one.reason;
}

TEST(Conformers, AnEnergyWindowIsKept) {
  const Conformers found = conformers_of(examples::heptane(), {.count = 40, .energy_window = 6});
  ASSERT_FALSE(found.energies.empty());
  for (const double energy : found.energies) EXPECT_LE(energy, found.energies.front() + 6);
}

TEST(Conformers, MoleculesWithoutBondsOrOfOneAtomAreTaken) {
  EXPECT_EQ(
      conformers_of(examples::loose_atoms({11}, {Vec3::Zero()}), {.count = 3}).positions.size(),
      3u);
  EXPECT_EQ(
      conformers_of(examples::loose_atoms({11, 17}, {Vec3::Zero(), Vec3(0.3, 0, 0)}), {.count = 3})
          .positions.size(),
      3u);
  EXPECT_EQ(conformers_of(examples::acetylene(), {.count = 3}).positions.size(), 3u);
}

TEST(Conformers, TheSearchIsStoppedWhenAskedTo) {
  const Molecule molecule = examples::heptane();
  const Conformers found =
      sample_conformers(molecule, {}, {.count = 1'000'000}, [] { return false; });
  EXPECT_LT(found.positions.size(), 1'000'000u);
  EXPECT_NE(found.reason.find("stopped"), std::string::npos) << found.reason;
}

TEST(Conformers, WhatMakesNoSenseIsRefused) {
  const Molecule molecule = examples::heptane();
  const auto refused = [&](const ConformerSettings& settings) {
    return refusal_of([&] { conformers_of(molecule, settings); });
  };
  EXPECT_NE(refused({.count = 0}), "");
  EXPECT_NE(refused({.prune_rmsd = -1}), "");
  EXPECT_NE(refused({.energy_window = -1}), "");
  EXPECT_NE(refused({.candidates = -1}), "");
  const TorsionTerm unknown{0, 1, 2, 99, {}, {}};
  EXPECT_NE(refusal_of([&] {
              conformers_of(molecule, {}, {&unknown, 1});
            }).find("atom 99"),
            std::string::npos);
}

TEST(PartTree, PartsThatDoNotTurnAreTheStart) {
  const Molecule molecule = examples::heptane();
  const PartTree tree(molecule, {});
  EXPECT_EQ(tree.parts().size(), 7u);
  const std::vector<double> angles(7, 0);
  const std::vector<int> shapes(7, 0);
  const std::vector<Vec3> x =
      place_parts(tree, molecule.atoms().size(), angles, shapes, molecule.positions());
  for (std::size_t i = 0; i < x.size(); ++i)
    EXPECT_NEAR((x[i] - molecule.positions()[i]).norm(), 0, 1e-12);
}

TEST(PartTree, ATurnAddsToItsTorsionAndToNoOther) {
  const Molecule molecule = examples::heptane();
  const PartTree tree(molecule, {});
  const std::vector<int> shapes(7, 0);
  for (std::size_t p = 1; p < 7; ++p) {
    std::vector<double> angles(7, 0);
    angles[p] = 0.7;
    const std::vector<Vec3> x =
        place_parts(tree, molecule.atoms().size(), angles, shapes, molecule.positions());
    for (std::size_t q = 1; q < 7; ++q) {
      const Part& part = tree.parts()[q];
      const auto torsion = [&](const std::vector<Vec3>& y) {
        return torsion_in(y, part.before, part.inner, part.outer, part.behind);
      };
      const double change =
          std::remainder(torsion(x) - torsion(molecule.positions()), 2 * std::numbers::pi);
      EXPECT_NEAR(change, p == q ? 0.7 : 0, 1e-9);
    }
  }
}

TEST(TorsionTable, DrawsAreAsOftenAsTheirWeightsSay) {
  std::array<double, TorsionTable::bins> energies;
  std::array<bool, TorsionTable::bins> allowed;
  for (std::size_t k = 0; k < energies.size(); ++k) {
    energies[k] = k < 180 ? 0 : std::log(3.0);
    allowed[k] = k != 7;
  }
  const TorsionTable table(energies, allowed, 1);
  Random random(1, RandomStream::conformers, 0);
  int low = 0, seventh = 0;
  constexpr int draws = 200'000;
  for (int k = 0; k < draws; ++k) {
    const int bin = table.draw(random);
    low += bin < 180;
    seventh += bin == 7;
  }
  EXPECT_EQ(seventh, 0);
  EXPECT_NEAR(double(low) / draws, 179.0 / (179 + 60), 0.005);
}

TEST(GraphSymmetry, PermutationsAreThoseOfTheGraph) {
  EXPECT_EQ(GraphSymmetry(examples::benzene(), 100).permutations().size(), 12u);
  EXPECT_EQ(GraphSymmetry(examples::heptane(), 100).permutations().size(), 2u);
  const GraphSymmetry amide(examples::formamide(), 100);
  EXPECT_EQ(amide.permutations().size(), 1u);
  EXPECT_TRUE(amide.complete());
  const GraphSymmetry cut(examples::benzene(), 5);
  EXPECT_EQ(cut.permutations().size(), 5u);
  EXPECT_FALSE(cut.complete());
}

TEST(LaneRmsd, IsTheSuperposedRmsd) {
  Random random(5, RandomStream::conformers, 1);
  constexpr std::size_t natom = 11;
  ConformerBlock block(natom);
  std::vector<std::vector<Vec3>> all;
  for (int k = 0; k < 21; ++k) {
    std::vector<Vec3> x;
    std::vector<float> places;
    for (std::size_t a = 0; a < natom; ++a) {
      x.emplace_back(random.uniform(), random.uniform(), 0.3 * random.uniform());
      for (const double value : x.back()) places.push_back(float(value));
    }
    // every third is nearly the one before
    if (k % 3 == 2)
      for (std::size_t a = 0; a < 3 * natom; ++a) {
        places[a] = float(all.back()[a / 3][Eigen::Index(a % 3)]) + 0.001f * float(a % 5);
        x[a / 3][Eigen::Index(a % 3)] = double(places[a]);
      }
    block.add(places);
    all.push_back(std::move(x));
  }
  const std::vector<std::vector<int>> none = {{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10}};
  SymmetricRmsd rmsd(block, none);
  for (std::size_t k = 0; k < all.size(); ++k) {
    std::vector<float> distances(block.padded_size(), 1e9f);
    rmsd.shorten(k, 0, distances);
    for (std::size_t j = 0; j < all.size(); ++j)
      EXPECT_NEAR(double(distances[j]), superposed_rmsd(all[k], all[j]),
                  1e-3 + 0.01 * superposed_rmsd(all[k], all[j]));
  }
}

}  // namespace
}  // namespace ragdoll
