#include "ragdoll/dilution.h"

#include <string>   // to_string
#include <utility>  // move

#include "disjoint_sets.h"  // DisjointSets
#include "pebble_game.h"    // PebbleGame
#include "ragdoll/error.h"  // Error

namespace ragdoll {
namespace {

void check(const BodyBarNetwork& network) {
  if (network.bodies <= 0) throw Error("the network has no bodies");
  for (std::size_t k = 0; k < network.bonds.size(); ++k) {
    const auto [a, b, bars] = network.bonds[k];
    const std::string name = "bond " + std::to_string(k) + " of the network";
    if (a < 0 || b < 0 || a >= network.bodies || b >= network.bodies)
      throw Error(name + " names a body that there is not");
    if (a == b) throw Error(name + " joins body " + std::to_string(a) + " to itself");
    if (bars < 1 || bars > rigid_bars)
      throw Error(name + " has " + std::to_string(bars) + " bars instead of 1 to 6");
  }
}

DisjointSets sets_of(int bodies, const std::vector<std::pair<int, int>>& merges,
                     std::size_t count) {
  DisjointSets sets(bodies);
  for (std::size_t k = 0; k < count; ++k) sets.join(merges[k].first, merges[k].second);
  return sets;
}

}  // namespace

Dilution::Dilution(BodyBarNetwork network, int fixed_bonds)
    : network_(std::move(network)), fixed_bonds_(fixed_bonds) {
  check(network_);
  const int bonds = int(network_.bonds.size());
  if (fixed_bonds < 0 || fixed_bonds > bonds)
    throw Error("the network has " + std::to_string(bonds) + " bonds, of which " +
                std::to_string(fixed_bonds) + " cannot be fixed");

  // One game merges only what is over-constrained, which is how it knows what that is; the other
  // merges whatever is rigid.
  PebbleGame game(network_.bodies);
  const auto add = [&](int k) {
    const auto [a, b, bars] = network_.bonds[std::size_t(k)];
    independent_bars_.push_back(game.add(a, b, bars));
  };
  for (int k = 0; k < fixed_bonds; ++k) add(k);
  PebbleGame rigid = game;
  for (int k = 0; k < fixed_bonds; ++k)
    rigid.join_if_rigid(network_.bonds[std::size_t(k)].a, network_.bonds[std::size_t(k)].b);

  const auto end_level = [&] {
    region_merges_at_.push_back(game.merges().size());
    cluster_merges_at_.push_back(rigid.merges().size());
  };
  end_level();
  for (int k = fixed_bonds; k < bonds; ++k) {
    const auto [a, b, bars] = network_.bonds[std::size_t(k)];
    add(k);
    // a cluster that this bond makes holds both its ends
    if (rigid.add(a, b, bars) > 0 && rigid.join_if_rigid(a, b)) rigid.settle(a);
    end_level();
  }
  cluster_merges_ = rigid.merges();
  region_merges_ = game.merges();
  visits_ = game.visits() + rigid.visits();
}

/// Hinges with an end that meets no other of the first `bonds` bonds.
std::vector<bool> Dilution::leaf_bonds(int bonds) const {
  std::vector<bool> leaf(std::size_t(bonds), false);
  if (!network_.lock_leaves) return leaf;
  std::vector<int> degree(std::size_t(network_.bodies), 0);
  for (int k = 0; k < bonds; ++k) {
    ++degree[std::size_t(network_.bonds[std::size_t(k)].a)];
    ++degree[std::size_t(network_.bonds[std::size_t(k)].b)];
  }
  for (int k = 0; k < bonds; ++k) {
    const auto [a, b, bars] = network_.bonds[std::size_t(k)];
    leaf[std::size_t(k)] =
        bars == hinge_bars && (degree[std::size_t(a)] == 1 || degree[std::size_t(b)] == 1);
  }
  return leaf;
}

Rigidity Dilution::at(int level) const {
  if (level < 0 || level >= level_count())
    throw Error("the dilution has levels 0 to " + std::to_string(level_count() - 1) + ", not " +
                std::to_string(level));
  const int bonds = fixed_bonds_ + level;
  // The pebble games leave a leaf its spin, for it may not be a leaf at the next level. Nothing
  // else depends on that spin: here its bar is put in, independent of all others.
  const std::vector<bool> leaf = leaf_bonds(bonds);
  DisjointSets clusters =
      sets_of(network_.bodies, cluster_merges_, cluster_merges_at_[std::size_t(level)]);
  DisjointSets regions =
      sets_of(network_.bodies, region_merges_, region_merges_at_[std::size_t(level)]);
  DisjointSets bodies(network_.bodies);

  Rigidity result;
  result.degrees_of_freedom = 6 * network_.bodies;
  result.separate_bodies = network_.bodies;
  for (int k = 0; k < bonds; ++k) {
    const auto [a, b, bars] = network_.bonds[std::size_t(k)];
    const int independent = independent_bars_[std::size_t(k)];
    result.degrees_of_freedom -= independent + (leaf[std::size_t(k)] ? 1 : 0);
    result.redundant_bars += bars - independent;
    if (leaf[std::size_t(k)]) clusters.join(a, b);
    if (bodies.find(a) != bodies.find(b)) --result.separate_bodies;
    bodies.join(a, b);
  }
  result.floppy_modes = result.degrees_of_freedom - 6 * result.separate_bodies;
  for (int k = 0; k < bonds; ++k) {
    const auto [a, b, bars] = network_.bonds[std::size_t(k)];
    if (bars == hinge_bars && clusters.find(a) != clusters.find(b)) result.hinges.push_back(k);
  }
  clusters.number(1, result.cluster_of_body, result.cluster_sizes);
  regions.number(2, result.region_of_body, result.region_sizes);
  return result;
}

}  // namespace ragdoll
