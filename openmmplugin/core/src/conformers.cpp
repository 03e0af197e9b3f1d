#include "ragdoll/conformers.h"

#include <algorithm>  // min, max, sort
#include <cmath>      // exp
#include <cstdlib>
#include <limits>     // max
#include <numeric>    // iota

#include "candidate_pool.h"
#include "diverse_choice.h"
#include "graph_symmetry.h"
#include "part_tree.h"
#include "ragdoll/error.h"            // Error
#include "ragdoll/ring_conformers.h"  // ring_conformers
#include "steric_rule.h"
#include "torsion_table.h"

namespace ragdoll {
namespace {

double tuned(const char* name, double value) {
  const char* text = std::getenv(name);
  return text ? std::atof(text) : value;
}

void check(const Molecule& molecule, std::span<const TorsionTerm> terms,
           const ConformerSettings& settings) {
  if (settings.count < 1) throw Error("the number of conformers must be 1 or more");
  if (!(settings.prune_rmsd >= 0)) throw Error("the least RMSD must not be negative");
  if (!(settings.energy_window >= 0)) throw Error("the energy window must not be negative");
  if (settings.candidates < 0) throw Error("the number of candidates must not be negative");
  if (molecule.atoms().empty()) throw Error("a molecule without atoms has no conformers");
  const int natom = int(molecule.atoms().size());
  for (const TorsionTerm& t : terms)
    for (const int atom : {t.a, t.b, t.c, t.d})
      if (atom < 0 || atom >= natom)
        throw Error("a torsion term names atom " + std::to_string(atom) +
                    ", which the molecule does not have");
}

std::vector<RingPool> ring_pools(const Molecule& molecule, std::span<const TorsionTerm> terms,
                                 std::uint64_t seed) {
  RingSettings rings;
  rings.seed = seed;
  rings.count = int(tuned("RINGS", 20));
  try {
    return ring_conformers(molecule, terms, rings);
  } catch (const Error&) {
    return {};  // rings whose start cannot be held keep the shape they have
  }
}

/// Candidates in rounds: chosen from each, until there are enough.
class Choice {
 public:
  Choice(const Molecule& molecule, const ConformerSettings& settings, CandidatePool& pool,
         const GraphSymmetry& symmetry)
      : molecule_(molecule), settings_(settings), pool_(pool), symmetry_(symmetry) {
    // ends that are equal stand in each other's middle, so that what exchanges only them is nothing
    std::vector<int> group(symmetry.atoms().size(), -1);
    for (std::size_t g = 0; g < symmetry.equal_ends().size(); ++g)
      for (const int place : symmetry.equal_ends()[g]) group[std::size_t(place)] = int(g);
    std::vector<std::vector<int>> classes;
    for (const std::vector<int>& permutation : symmetry.permutations()) {
      std::vector<int> reduced;
      for (const int image : permutation)
        reduced.push_back(group[std::size_t(image)] < 0
                              ? image
                              : symmetry.equal_ends()[std::size_t(group[std::size_t(image)])][0]);
      if (std::find(classes.begin(), classes.end(), reduced) == classes.end())
        classes.push_back(std::move(reduced));
      if (classes.size() == std::size_t(tuned("PERMS", 8))) break;
    }
    permutations_ = std::move(classes);
  }

  std::vector<float> merged(std::span<const float> places) const {
    std::vector<float> x(places.begin(), places.end());
    for (const std::vector<int>& ends : symmetry_.equal_ends())
      for (std::size_t k = 0; k < 3; ++k) {
        float sum = 0;
        for (const int end : ends) sum += places[3 * std::size_t(end) + k];
        for (const int end : ends) x[3 * std::size_t(end) + k] = sum / float(ends.size());
      }
    return x;
  }

  /// Indices of candidates that stand for all.
  std::vector<int> choose(int count) const {
    ConformerBlock block(symmetry_.atoms().size());
    std::vector<float> weights;
    std::vector<int> within;
    double least = std::numeric_limits<double>::max();
    for (std::size_t k = 0; k < pool_.size(); ++k) least = std::min(least, pool_.energy(k));
    const double te = tuned("T_WEIGHT", 1000);
    for (std::size_t k = 0; k < pool_.size(); ++k) {
      if (settings_.energy_window > 0 && pool_.energy(k) > least + settings_.energy_window) continue;
      within.push_back(int(k));
      block.add(merged(pool_.places(k)));
      weights.push_back(float(std::exp(-(pool_.energy(k) - least) / te)));
    }
    std::vector<int> chosen =
        choose_diverse(block, permutations_, weights, count, int(tuned("ROUNDS", 2)));
    for (int& k : chosen) k = within[std::size_t(k)];
    return chosen;
  }

 private:
  const Molecule& molecule_;
  const ConformerSettings& settings_;
  CandidatePool& pool_;
  const GraphSymmetry& symmetry_;
  std::vector<std::vector<int>> permutations_;
};

}  // namespace

Conformers sample_conformers(const Molecule& molecule, std::span<const TorsionTerm> terms,
                             const ConformerSettings& settings,
                             const std::function<bool()>& keep_going) {
  check(molecule, terms, settings);
  PartTree tree(molecule, terms);
  tree.add_shapes(ring_pools(molecule, terms, settings.seed), 40);
  const StericRule sterics(molecule);
  const GraphSymmetry symmetry(molecule, 1000);
  CandidatePool pool(molecule, tree, sterics,
                     torsion_tables(molecule, tree, terms, sterics, tuned("T_TORSION", 2.5)),
                     settings.seed, symmetry.atoms());
  Choice choice(molecule, settings, pool, symmetry);
  Conformers found;
  const int ratio = int(tuned("RATIO", 20));
  pool.fill(std::size_t(ratio * settings.count), keep_going);
  found.candidates = long(pool.size());
  found.rejected = pool.rejected();
  for (const int k : choice.choose(settings.count)) {
    found.positions.push_back(pool.positions(std::size_t(k)));
    found.energies.push_back(pool.energy(std::size_t(k)));
  }
  return found;
}

}  // namespace ragdoll
