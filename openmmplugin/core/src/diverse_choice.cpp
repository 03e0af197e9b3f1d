#include "diverse_choice.h"

#include <algorithm>  // fill, min
#include <limits>
#include <numeric>  // iota

namespace ragdoll {
namespace {

constexpr float far_away = std::numeric_limits<float>::max();

}  // namespace

void SymmetricRmsd::shorten(std::size_t conformer, const ConformerBlock& others, std::size_t first,
                            std::span<float> distances) {
  block_.get(conformer, plain_);
  const float norm = block_.norm(conformer);
  for (const std::vector<int>& permutation : permutations_) {
    for (std::size_t a = 0; a < permutation.size(); ++a)
      for (std::size_t k = 0; k < 3; ++k)
        permuted_[3 * a + k] = plain_[3 * std::size_t(permutation[a]) + k];
    others.shorten(permuted_, norm, first, distances);
  }
}

std::vector<int> choose_diverse(const ConformerBlock& block,
                                const std::vector<std::vector<int>>& permutations,
                                std::span<const float> weights, int count, int rounds) {
  const std::size_t n = block.size(), padded = block.padded_size();
  std::vector<int> chosen;
  if (int(n) <= count) {
    chosen.resize(n);
    std::iota(chosen.begin(), chosen.end(), 0);
    return chosen;
  }
  SymmetricRmsd rmsd(block, permutations);
  std::vector<float> nearest(padded), distance(padded);
  std::vector<int> owner(n);
  const auto assign = [&](int which) {
    std::fill(distance.begin(), distance.end(), far_away);
    rmsd.shorten(std::size_t(chosen[std::size_t(which)]), 0, distance);
    for (std::size_t k = 0; k < n; ++k)
      if (distance[k] < nearest[k]) {
        nearest[k] = distance[k];
        owner[k] = which;
      }
  };

  // seeds: the one that is worst off, by its weight, next
  std::fill(nearest.begin(), nearest.end(), far_away);
  std::size_t next = 0;
  for (std::size_t k = 0; k < n; ++k)
    if (weights[k] > weights[next]) next = k;
  for (int c = 0; c < count; ++c) {
    chosen.push_back(int(next));
    assign(c);
    float worst = -1;
    for (std::size_t k = 0; k < n; ++k)
      if (nearest[k] * weights[k] > worst) {
        worst = nearest[k] * weights[k];
        next = k;
      }
  }

  std::vector<std::vector<int>> members(static_cast<std::size_t>(count));
  std::vector<float> places(3 * block.atom_count());
  for (int round = 0; round < rounds; ++round) {
    for (auto& list : members) list.clear();
    for (std::size_t k = 0; k < n; ++k) members[std::size_t(owner[k])].push_back(int(k));
    bool changed = false;
    for (std::size_t c = 0; c < members.size(); ++c) {
      const std::vector<int>& own = members[c];
      if (own.size() < 3) continue;
      ConformerBlock cluster(block.atom_count());
      for (const int k : own) {
        block.get(std::size_t(k), places);
        cluster.add(places);
      }
      SymmetricRmsd within(cluster, permutations);
      std::vector<float> sums(own.size(), 0), row(cluster.padded_size());
      for (std::size_t k = 0; k < own.size(); ++k) {
        std::fill(row.begin(), row.end(), far_away);
        within.shorten(k, 0, row);
        const float weight = weights[std::size_t(own[k])];
        for (std::size_t j = 0; j < own.size(); ++j) sums[j] += weight * row[j];
      }
      const std::size_t best =
          std::size_t(std::min_element(sums.begin(), sums.end()) - sums.begin());
      if (own[best] != chosen[c]) {
        chosen[c] = own[best];
        changed = true;
      }
    }
    if (!changed || round + 1 == rounds) break;
    std::fill(nearest.begin(), nearest.end(), far_away);
    for (int c = 0; c < count; ++c) assign(c);
  }
  return chosen;
}

}  // namespace ragdoll
