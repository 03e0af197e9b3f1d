#include "ragdoll/hinge_groups.h"

#include <algorithm>  // max_element, sort
#include <tuple>      // tuple

#include "disjoint_sets.h"  // DisjointSets
#include "pebble_game.h"    // PebbleGame

namespace ragdoll {
namespace {

/// Hinges between the clusters that they join.
struct ClusterHinges {
  std::vector<std::pair<int, int>> ends;     ///< clusters (nhinge)
  std::vector<std::vector<int>> at_cluster;  ///< locked hinges (ncluster)
  std::vector<int> mark;                     ///< last set that held a cluster (ncluster)

  /// Calls for each locked hinge with both ends in a set of clusters.
  template <class Call>
  void for_locked_in(const std::vector<int>& set, int number, Call call) {
    for (const int cluster : set) mark[std::size_t(cluster)] = number;
    // each hinge has an end elsewhere than at the cluster with the most hinges, which may have very
    // many
    const int most = *std::max_element(set.begin(), set.end(), [&](int a, int b) {
      return at_cluster[std::size_t(a)].size() < at_cluster[std::size_t(b)].size();
    });
    for (const int cluster : set) {
      if (cluster == most) continue;
      for (const int hinge : at_cluster[std::size_t(cluster)]) {
        const auto [a, b] = ends[std::size_t(hinge)];
        if (mark[std::size_t(a == cluster ? b : a)] == number) call(hinge);
      }
    }
  }
};

}  // namespace

std::vector<HingeGroup> hinge_groups(const BodyBarNetwork& network, const Rigidity& rigidity) {
  const int clusters = int(rigidity.cluster_sizes.size()), count = int(rigidity.hinges.size());
  const auto cluster_of = [&](int body) { return rigidity.cluster_of_body[std::size_t(body)]; };

  // clusters are the bodies; no bar between two of them is redundant
  PebbleGame game(clusters);
  for (const BodyBond& bond : network.bonds) {
    const int a = cluster_of(bond.a), b = cluster_of(bond.b);
    if (a != b) game.add(a, b, bond.bars);
  }

  // Hinges are locked one by one, by a bar each. Where a lock is redundant, the locks within the
  // smallest rigid set around it hold it already: these hinges turn together.
  ClusterHinges hinges;
  hinges.at_cluster.resize(std::size_t(clusters));
  hinges.mark.assign(std::size_t(clusters), -1);
  DisjointSets together(count);
  std::vector<bool> independent(std::size_t(count), false);
  for (int k = 0; k < count; ++k) {
    const BodyBond& bond = network.bonds[std::size_t(rigidity.hinges[std::size_t(k)])];
    const int a = cluster_of(bond.a), b = cluster_of(bond.b);
    hinges.ends.emplace_back(a, b);
    const std::vector<int> set = game.rigid_set(a, b);
    if (set.empty()) {
      game.add(a, b, 1);
      independent[std::size_t(k)] = true;
      hinges.at_cluster[std::size_t(a)].push_back(k);
      hinges.at_cluster[std::size_t(b)].push_back(k);
    } else {
      hinges.for_locked_in(set, k, [&](int other) { together.join(k, other); });
    }
  }

  std::vector<int> group_of, sizes;
  together.number(1, group_of, sizes);
  std::vector<HingeGroup> groups(sizes.size());
  for (int k = 0; k < count; ++k) {
    HingeGroup& group = groups[std::size_t(group_of[std::size_t(k)])];
    group.hinges.push_back(rigidity.hinges[std::size_t(k)]);
    if (independent[std::size_t(k)]) ++group.freedom;
  }
  std::sort(groups.begin(), groups.end(), [](const HingeGroup& a, const HingeGroup& b) {
    return std::tuple(-a.freedom, -int(a.hinges.size()), a.hinges.front()) <
           std::tuple(-b.freedom, -int(b.hinges.size()), b.hinges.front());
  });
  return groups;
}

}  // namespace ragdoll
