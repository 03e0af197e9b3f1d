#include "newton_range.h"

#include <algorithm>  // sort
#include <utility>    // pair

namespace ragdoll {
namespace {

/// Further than this, distances are not told apart.
constexpr int furthest = 16;

/// Joints that bars join to each.
struct Neighbours {
  std::vector<std::vector<int>> of;
  explicit Neighbours(const Framework& framework) : of(std::size_t(framework.joint_count())) {
    for (const Bar& bar : framework.bars()) {
      of[std::size_t(bar.p)].push_back(bar.q);
      of[std::size_t(bar.q)].push_back(bar.p);
    }
  }
};

}  // namespace

NewtonRange::NewtonRange(const Framework& framework) : tethers_(framework.tethers().size()) {
  std::vector<std::pair<int, int>> pairs;
  for (const Tether& tether : framework.tethers()) pairs.emplace_back(tether.p, tether.q);
  for (const Contact& contact : framework.contacts()) pairs.emplace_back(contact.p, contact.q);
  apart_.assign(pairs.size(), anywhere);
  if (pairs.empty()) return;
  const Neighbours neighbours(framework);
  std::vector<std::size_t> by_start(pairs.size());
  for (std::size_t k = 0; k < pairs.size(); ++k) by_start[k] = k;
  std::sort(by_start.begin(), by_start.end(),
            [&](std::size_t one, std::size_t two) { return pairs[one] < pairs[two]; });
  std::vector<int> distance(std::size_t(framework.joint_count()), anywhere), found;
  int start = -1;
  for (const std::size_t k : by_start) {
    const auto [p, q] = pairs[k];
    if (framework.fixed()[std::size_t(p)] || framework.fixed()[std::size_t(q)]) {
      apart_[k] = -1;
      continue;
    }
    if (p != start) {
      start = p;
      for (const int joint : found) distance[std::size_t(joint)] = anywhere;
      found.assign(1, p);
      distance[std::size_t(p)] = 0;
      for (std::size_t next = 0; next < found.size(); ++next) {
        const int joint = found[next], further = distance[std::size_t(joint)] + 1;
        if (further > furthest) break;
        for (const int other : neighbours.of[std::size_t(joint)]) {
          if (distance[std::size_t(other)] != anywhere) continue;
          distance[std::size_t(other)] = further;
          found.push_back(other);
        }
      }
    }
    apart_[k] = distance[std::size_t(q)];
  }
}

}  // namespace ragdoll
