#include "ragdoll/conformers.h"

#include <algorithm>  // any_of, min, max, min_element, iter_swap, sort, find
#include <cmath>      // exp
#include <limits>     // max
#include <numeric>    // iota
#include <utility>    // move

#include "candidate_pool.h"
#include "diverse_choice.h"
#include "graph_symmetry.h"
#include "part_tree.h"
#include "ragdoll/error.h"            // Error
#include "ragdoll/ring_conformers.h"  // ring_conformers
#include "ragdoll/ring_systems.h"     // ring_systems
#include "steric_rule.h"
#include "torsion_table.h"

namespace ragdoll {
namespace {

/// Values found on one half of a set of protein-bound ligands, looked at on the other. kJ/mol
constexpr double torsion_temperature = 2.5;
/// Terms are stiff, fitted to hold embeddings: of their amplitudes so much tells how often a
/// torsion is what.
constexpr double term_share = 0.24;
constexpr double weight_temperature = 40;

constexpr int ring_shapes = 10, part_shapes = 20;
/// Of large rings: as many as there are conformers, at most so many. Shapes between those that
/// torsions like are asked for where there are this many times more conformers than those.
constexpr int most_ring_shapes = 1000, filled_from = 4;
constexpr int most_atoms = 5000;
constexpr std::size_t most_permutations = 200;
/// Permutations that the choice looks at; those which make a difference of a few atoms come late.
constexpr std::size_t choice_permutations = 8;
/// So many conformers are chosen together, each from so many candidates.
constexpr int choice_rounds = 1;
constexpr int largest_choice = 200, most_ratio = 10, least_ratio = 3;
/// Pairs that candidates of one choice cost at most, before there are fewer of them.
constexpr double choice_work = 3e8;
/// Rounds in which pruning finds nothing that is new, before it ends.
constexpr int most_idle_rounds = 2;

void check(const Molecule& molecule, std::span<const TorsionTerm> terms,
           const ConformerSettings& settings) {
  if (settings.count < 1) throw Error("the number of conformers must be 1 or more");
  if (!(settings.prune_rmsd >= 0)) throw Error("the least RMSD must not be negative");
  if (!(settings.energy_window >= 0)) throw Error("the energy window must not be negative");
  if (settings.candidates < 0) throw Error("the number of candidates must not be negative");
  const int natom = int(molecule.atoms().size());
  if (natom == 0) throw Error("a molecule without atoms has no conformers");
  if (natom > most_atoms)
    throw Error("conformers are for molecules of at most " + std::to_string(most_atoms) +
                " atoms, and this one has " + std::to_string(natom) +
                "; sample it with walkers instead");
  for (const TorsionTerm& t : terms)
    for (const int atom : {t.a, t.b, t.c, t.d})
      if (atom < 0 || atom >= natom)
        throw Error("a torsion term names atom " + std::to_string(atom) +
                    ", which the molecule does not have");
}

bool has_large_ring(const Molecule& molecule) {
  const std::vector<RingSystem> systems = ring_systems(molecule);
  return std::any_of(systems.begin(), systems.end(),
                     [](const RingSystem& system) { return system.largest_ring() >= large_ring; });
}

/// @param large  the most shapes of each ring system; 0: no ring is large
/// @param alone  whether there is nothing else that moves
std::vector<RingPool> ring_pools(const Molecule& molecule, std::span<const TorsionTerm> terms,
                                 std::uint64_t seed, int large, bool alone) {
  RingSettings rings;
  rings.seed = seed;
  rings.count = std::max(large, ring_shapes);
  try {
    std::vector<RingPool> pools = ring_conformers(molecule, terms, rings);
    if (alone && pools.size() == 1 && large > filled_from * pools.front().minima) {
      rings.fill = true;
      pools = ring_conformers(molecule, terms, rings);
    }
    return pools;
  } catch (const Error&) {
    return {};  // rings whose start cannot be held keep the shape they have
  }
}

std::vector<std::vector<int>> first_of(const std::vector<std::vector<int>>& all,
                                       std::size_t count) {
  return {all.begin(), all.begin() + long(std::min(count, all.size()))};
}

/// Chooses from candidates, until there are enough.
class Choice {
 public:
  Choice(const ConformerSettings& settings, CandidatePool& pool, const GraphSymmetry& symmetry,
         std::size_t pairs)
      : settings_(settings),
        pool_(pool),
        symmetry_(symmetry),
        pairs_(double(std::max<std::size_t>(pairs, 1))),
        exact_(first_of(symmetry.permutations(), most_permutations)),
        kept_(symmetry.atoms().size()) {
    // equal ends stand in each other's middle, so that what exchanges only them changes nothing
    std::vector<int> group(symmetry.atoms().size(), -1);
    for (std::size_t g = 0; g < symmetry.equal_ends().size(); ++g)
      for (const int place : symmetry.equal_ends()[g]) group[std::size_t(place)] = int(g);
    for (const std::vector<int>& permutation : symmetry.permutations()) {
      std::vector<int> merged;
      for (const int image : permutation) {
        const int g = group[std::size_t(image)];
        merged.push_back(g < 0 ? image : symmetry.equal_ends()[std::size_t(g)][0]);
      }
      if (std::find(merged_.begin(), merged_.end(), merged) == merged_.end())
        merged_.push_back(std::move(merged));
      if (merged_.size() == choice_permutations) break;
    }
  }

  void run(Conformers& found, const std::function<bool()>& keep_going) {
    bool goes_on = true, exhausted = false;
    for (int idle = 0; goes_on && !exhausted && missing() > 0 && idle < most_idle_rounds;) {
      const bool shapes = pool_.only_shapes();
      const int count = shapes ? missing() : std::min(missing(), largest_choice);
      if (shapes)
        pool_.fill_with_shapes();
      else
        goes_on = pool_.fill(wanted(count), keep_going);
      exhausted = pool_.exhausted();
      found.candidates += long(pool_.size());
      const std::size_t before = frames_.size();
      take(count);
      idle = frames_.size() == before ? idle + 1 : 0;
      pool_.clear();
    }
    found.rejected = pool_.rejected();
    if (missing() > 0) found.reason = reason(goes_on, exhausted);

    std::vector<std::size_t> order(frames_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return energies_[a] < energies_[b]; });
    for (const std::size_t k : order) {
      found.positions.push_back(std::move(frames_[k]));
      found.energies.push_back(energies_[k]);
    }
  }

 private:
  int missing() const { return settings_.count - int(frames_.size()); }

  std::size_t wanted(int count) const {
    if (settings_.candidates > 0)
      return std::size_t(
          std::max(count, int(double(settings_.candidates) * count / settings_.count)));
    const double ratio =
        std::clamp(50.0 * most_ratio / settings_.count, double(least_ratio), double(most_ratio));
    return std::size_t(std::max(double(count), std::min(ratio * count, choice_work / pairs_)));
  }

  std::string reason(bool goes_on, bool exhausted) const {
    const std::string number = std::to_string(frames_.size());
    if (!goes_on) return "the search was stopped after " + number + " conformers";
    if (exhausted)
      return "only " + number + " arrangements without clashes were found in the time there is";
    if (settings_.prune_rmsd > 0)
      return "only " + number + " conformers were found that are " +
             std::to_string(10 * settings_.prune_rmsd) + " angstrom or more apart";
    return "only " + number + " conformers were found within the energy window";
  }

  std::vector<float> merged_places(std::span<const float> places) const {
    std::vector<float> x(places.begin(), places.end());
    for (const std::vector<int>& ends : symmetry_.equal_ends())
      for (std::size_t k = 0; k < 3; ++k) {
        float sum = 0;
        for (const int end : ends) sum += places[3 * std::size_t(end) + k];
        for (const int end : ends) x[3 * std::size_t(end) + k] = sum / float(ends.size());
      }
    return x;
  }

  void keep(int candidate) {
    frames_.push_back(pool_.positions(std::size_t(candidate)));
    energies_.push_back(pool_.energy(std::size_t(candidate)));
  }

  void take(int count) {
    for (std::size_t k = 0; k < pool_.size(); ++k) least_ = std::min(least_, pool_.energy(k));
    std::vector<int> within;
    for (std::size_t k = 0; k < pool_.size(); ++k)
      if (!(settings_.energy_window > 0) || pool_.energy(k) <= least_ + settings_.energy_window)
        within.push_back(int(k));
    if (within.empty()) return;
    ConformerBlock block(symmetry_.atoms().size());
    std::vector<float> weights;
    for (const int k : within) {
      block.add(merged_places(pool_.places(std::size_t(k))));
      weights.push_back(
          float(std::exp(-(pool_.energy(std::size_t(k)) - least_) / weight_temperature)));
    }
    const std::vector<int> chosen =
        pool_.even_shape(0) >= 0 ? one_of_each_shape(within, count)
                                 : choose_diverse(block, merged_, weights, count, choice_rounds);
    if (settings_.prune_rmsd > 0)
      take_apart(chosen, within);
    else
      for (const int k : chosen) keep(within[std::size_t(k)]);
  }

  /// Indices of `within`: of each shape of a large ring the candidate of least energy, then others
  /// in turn, as they were drawn.
  std::vector<int> one_of_each_shape(const std::vector<int>& within, int count) const {
    std::vector<std::vector<int>> of_shape;
    for (std::size_t k = 0; k < within.size(); ++k) {
      const std::size_t shape = std::size_t(pool_.even_shape(std::size_t(within[k])));
      if (of_shape.size() <= shape) of_shape.resize(shape + 1);
      of_shape[shape].push_back(int(k));
    }
    for (std::vector<int>& own : of_shape) {
      const auto least = std::min_element(own.begin(), own.end(), [&](int a, int b) {
        return pool_.energy(std::size_t(within[std::size_t(a)])) <
               pool_.energy(std::size_t(within[std::size_t(b)]));
      });
      if (least != own.end()) std::iter_swap(own.begin(), least);
    }
    std::vector<int> chosen;
    const std::size_t most = std::min(std::size_t(count), within.size());
    for (std::size_t turn = 0; chosen.size() < most; ++turn)
      for (const std::vector<int>& own : of_shape)
        if (turn < own.size() && chosen.size() < most) chosen.push_back(own[turn]);
    return chosen;
  }

  /// Those chosen first, then all others, as long as they are far enough from what is kept.
  void take_apart(const std::vector<int>& chosen, const std::vector<int>& within) {
    ConformerBlock block(symmetry_.atoms().size());
    std::vector<bool> first(within.size(), false);
    std::vector<int> order = chosen;
    for (const int k : chosen) first[std::size_t(k)] = true;
    for (std::size_t k = 0; k < within.size(); ++k)
      if (!first[k]) order.push_back(int(k));
    for (const int k : order) block.add(pool_.places(std::size_t(within[std::size_t(k)])));
    std::vector<float> nearest(block.padded_size(), std::numeric_limits<float>::max());
    SymmetricRmsd kept(kept_, exact_), rmsd(block, exact_);
    for (std::size_t k = 0; k < kept_.size(); ++k) kept.shorten(k, block, 0, nearest);
    const float least = float(settings_.prune_rmsd);
    for (std::size_t k = 0; k < order.size() && missing() > 0; ++k) {
      if (nearest[k] < least) continue;
      const int candidate = within[std::size_t(order[k])];
      keep(candidate);
      kept_.add(pool_.places(std::size_t(candidate)));
      const std::size_t from = k / ConformerBlock::lanes * ConformerBlock::lanes;
      rmsd.shorten(k, block, from, std::span(nearest).subspan(from));
    }
  }

  const ConformerSettings& settings_;
  CandidatePool& pool_;
  const GraphSymmetry& symmetry_;
  double pairs_;
  std::vector<std::vector<int>> exact_, merged_;  ///< permutations
  ConformerBlock kept_;
  std::vector<std::vector<Vec3>> frames_;
  std::vector<double> energies_;
  double least_ = std::numeric_limits<double>::max();
};

std::vector<TorsionTerm> softened(std::span<const TorsionTerm> terms) {
  std::vector<TorsionTerm> soft(terms.begin(), terms.end());
  for (TorsionTerm& term : soft)
    for (double& amplitude : term.amplitude) amplitude *= term_share;
  return soft;
}

}  // namespace

Conformers sample_conformers(const Molecule& molecule, std::span<const TorsionTerm> given,
                             const ConformerSettings& settings,
                             const std::function<bool()>& keep_going) {
  check(molecule, given, settings);
  const std::vector<TorsionTerm> terms = softened(given);
  PartTree tree(molecule, terms);
  const int large = has_large_ring(molecule) ? std::min(settings.count, most_ring_shapes) : 0;
  const std::vector<RingPool> pools =
      ring_pools(molecule, terms, settings.seed, large, tree.parts().size() == 1);
  tree.add_shapes(pools, std::max(large, part_shapes));
  const StericRule sterics(molecule);
  const GraphSymmetry symmetry(molecule, 5 * most_permutations);
  CandidatePool pool(molecule, tree, sterics,
                     torsion_tables(molecule, tree, terms, sterics, torsion_temperature),
                     settings.seed, symmetry.atoms());
  Conformers found;
  if (!pool.has_freedom()) {
    // there is one conformer, however many are asked for
    const int copies = settings.prune_rmsd > 0 ? 1 : settings.count;
    found.positions.assign(std::size_t(copies), molecule.positions());
    found.energies.assign(std::size_t(copies), 0);
    found.candidates = 1;
    if (copies < settings.count) found.reason = "the molecule is rigid and has one conformer";
    return found;
  }
  Choice(settings, pool, symmetry, pool.pair_count()).run(found, keep_going);
  if (found.positions.empty()) {
    // the start is one, whatever its clashes
    found.positions.push_back(molecule.positions());
    found.energies.push_back(0);
    found.reason += "; the one given is returned";
  }
  return found;
}

}  // namespace ragdoll
