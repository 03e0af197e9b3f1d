#include "newton_repair.h"

#include <algorithm>  // sort, max, min
#include <array>
#include <cmath>    // cbrt, abs
#include <numeric>  // iota, partial_sum
#include <utility>  // move

#include "newton_engine.h"         // NewtonEngine, NewtonTask
#include "ragdoll/contact_list.h"  // ContactList
#include "ragdoll/random.h"        // Random

namespace ragdoll {
namespace {

/// How far around a trap joints may move, in bars, and how each try is shaken: by how much of the
/// length of what is violated.
constexpr std::array<int, 3> radii = {2, 4, 7};
constexpr std::array<double, 5> shakes = {0.3, 0.6, 0.2, 1.0, 0.45};

/// The worst of a cluster: those violated by this share of its worst. More joints than this are not
/// taken out at once.
constexpr double worst_share = 0.3;
constexpr std::size_t most_joints = 600;

constexpr std::int64_t try_iterations = 40;

/// Notably better: so much of the energy is left.
constexpr double better = 0.7;

/// Clusters that cannot be repaired, before the others are left alone: at least so many, and more
/// than could.
constexpr int most_failures = 8;

/// Pairs of the contact rule up to their bound plus this may be met while joints are shaken. nm
constexpr double contact_reach = 0.15;

}  // namespace

NewtonRepair::NewtonRepair(std::shared_ptr<const Framework> framework,
                           const ResolverSettings& settings)
    : framework_(std::move(framework)), settings_(settings) {
  local_.assign(std::size_t(framework_->joint_count()), -1);
  index_constraints();
}

void NewtonRepair::index_constraints() {
  const Framework& f = *framework_;
  use_begin_.assign(std::size_t(f.joint_count()) + 1, 0);
  const auto each_use = [&](auto visit) {
    std::int64_t k = 0;
    const auto pairs = [&](const auto& list) {
      for (const auto& pair : list) {
        visit(pair.p, k);
        visit(pair.q, k++);
      }
    };
    pairs(f.bars());
    pairs(f.tethers());
    pairs(f.contacts());
    for (const Volume& v : f.volumes()) {
      for (const int joint : {v.a, v.b, v.c, v.d}) visit(joint, k);
      ++k;
    }
  };
  each_use([&](int joint, std::int64_t) { ++use_begin_[std::size_t(joint) + 1]; });
  std::partial_sum(use_begin_.begin(), use_begin_.end(), use_begin_.begin());
  uses_.resize(std::size_t(use_begin_.back()));
  std::vector<std::int64_t> next(use_begin_.begin(), use_begin_.end() - 1);
  each_use([&](int joint, std::int64_t k) { uses_[std::size_t(next[std::size_t(joint)]++)] = k; });
}

void NewtonRepair::find_near_pairs(std::span<const Vec3> positions, const Box* box, double reach) {
  near_.clear();
  const ContactRule& rule = framework_->contact_rule();
  if (rule.empty()) return;
  ContactList list(rule, reach);
  list.update(positions, box, 0);
  near_of_.assign(positions.size(), {});
  for (const NearPair& pair : list.pairs()) {
    near_of_[std::size_t(pair.p)].push_back(int(near_.size()));
    near_of_[std::size_t(pair.q)].push_back(int(near_.size()));
    near_.push_back({pair.p, pair.q, pair.bound});
  }
}

std::vector<NewtonRepair::Broken> NewtonRepair::find_broken(std::span<const Vec3> positions,
                                                            const Box* box) {
  const Framework& f = *framework_;
  std::vector<Broken> broken;
  const auto at = [&](int joint) -> const Vec3& { return positions[std::size_t(joint)]; };
  const auto consider = [&](int p, int q, double length, int side, const Box* image) {
    Vec3 d = at(q) - at(p);
    if (image) d = image->minimum_image(d);
    const double row = d.norm() - length, slack = settings_.tolerance.slack(length);
    if (side * row < 0 || !(std::abs(row) > slack)) return;
    broken.push_back({{p, q}, std::abs(row) / slack, length});
  };
  for (const Bar& bar : f.bars()) consider(bar.p, bar.q, bar.length, 0, nullptr);
  for (const Tether& tether : f.tethers()) consider(tether.p, tether.q, tether.length, 1, nullptr);
  for (const Contact& contact : f.contacts())
    consider(contact.p, contact.q, contact.length, -1, nullptr);
  for (const NearContact& pair : near_) consider(pair.p, pair.q, pair.bound, -1, box);
  for (const Volume& v : f.volumes()) {
    const double volume = signed_volume(at(v.a), at(v.b), at(v.c), at(v.d));
    const double excess = std::max({v.lower - volume, volume - v.upper, 0.0});
    const double slack = settings_.tolerance.volume_slack(v.scale);
    if (excess > slack)
      broken.push_back({{v.a, v.b, v.c, v.d}, excess / slack, std::cbrt(v.scale)});
  }
  return broken;
}

/// Those that share a joint, directly or by others; of each cluster the worst.
std::vector<std::vector<NewtonRepair::Broken>> NewtonRepair::cluster(
    std::vector<Broken> broken) const {
  std::vector<int> root(broken.size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&root](int k) {
    while (root[std::size_t(k)] != k)
      k = root[std::size_t(k)] = root[std::size_t(root[std::size_t(k)])];
    return k;
  };
  std::vector<std::pair<int, int>> uses;  // joint, constraint
  for (std::size_t k = 0; k < broken.size(); ++k)
    for (const int joint : broken[k].joints)
      if (!framework_->fixed()[std::size_t(joint)]) uses.emplace_back(joint, int(k));
  std::sort(uses.begin(), uses.end());
  for (std::size_t k = 1; k < uses.size(); ++k)
    if (uses[k].first == uses[k - 1].first)
      root[std::size_t(find(uses[k].second))] = find(uses[k - 1].second);
  std::vector<double> worst(broken.size(), 0);
  for (std::size_t k = 0; k < broken.size(); ++k) {
    double& value = worst[std::size_t(find(int(k)))];
    value = std::max(value, broken[k].violation);
  }
  std::vector<std::vector<Broken>> clusters;
  std::vector<int> number(broken.size(), -1);
  for (std::size_t k = 0; k < broken.size(); ++k) {
    const std::size_t r = std::size_t(find(int(k)));
    if (broken[k].violation < worst_share * worst[r]) continue;
    if (number[r] < 0) {
      number[r] = int(clusters.size());
      clusters.emplace_back();
    }
    clusters[std::size_t(number[r])].push_back(std::move(broken[k]));
  }
  return clusters;
}

NewtonRepair::Result NewtonRepair::repair(std::span<Vec3> positions, const Box* box, int round,
                                          std::int64_t max_iterations) {
  Result result;
  find_near_pairs(positions, box, contact_reach);
  int failures = 0;
  for (const auto& cluster : cluster(find_broken(positions, box))) {
    const Tally tally = repair_cluster(cluster, positions, box, round, max_iterations);
    result.repaired += tally.better;
    failures += !tally.better;
    result.iterations = std::max(result.iterations, tally.iterations);
    result.bar_visits += tally.bar_visits;
    if (failures > most_failures && failures > result.repaired) break;
  }
  return result;
}

NewtonRepair::Tally NewtonRepair::repair_cluster(const std::vector<Broken>& cluster,
                                                 std::span<Vec3> positions, const Box* box,
                                                 int round, std::int64_t max_iterations) {
  Tally tally;
  std::vector<int> centre;
  double length = 0;
  for (const Broken& broken : cluster) {
    for (const int joint : broken.joints)
      if (!framework_->fixed()[std::size_t(joint)]) centre.push_back(joint);
    length += broken.length / double(cluster.size());
  }
  std::sort(centre.begin(), centre.end());
  centre.erase(std::unique(centre.begin(), centre.end()), centre.end());
  if (centre.empty()) return tally;

  std::size_t former = 0;
  std::int64_t spent = 0;  // iterations of all tries
  for (const int radius : radii) {
    const std::vector<int> free = ball(centre, radius);
    if (free.size() > most_joints || free.size() == former) break;
    former = free.size();
    std::vector<int> joints;
    const auto part = cut_out(free, positions, box, joints);
    ResolverSettings settings = settings_;
    settings.precision = Precision::double_;
    const auto engine = make_newton_engine(std::make_shared<const NewtonTask>(part, settings),
                                           Precision::double_, true);
    std::vector<Vec3> start(joints.size()), x, best;
    for (std::size_t k = 0; k < joints.size(); ++k) start[k] = positions[std::size_t(joints[k])];
    double first_energy = 0, best_energy = 0;
    for (std::size_t attempt = 0; attempt <= shakes.size(); ++attempt) {
      if (spent >= max_iterations) return tally;
      x = start;
      if (attempt > 0) {
        // free joints come first, sorted as they are
        const std::uint64_t address = (std::uint64_t(round) << 40) + (std::uint64_t(radius) << 36) +
                                      (std::uint64_t(attempt) << 32) + std::uint64_t(centre[0]);
        Random random(0, RandomStream::order, address);
        const double size = length * shakes[attempt - 1];
        for (const int joint : centre) {
          const auto at = std::lower_bound(free.begin(), free.end(), joint);
          Vec3& point = x[std::size_t(at - free.begin())];
          for (int i = 0; i < 3; ++i) point[i] += size * (2 * random.uniform() - 1);
        }
      }
      engine->load(0, x, nullptr, std::min(try_iterations, max_iterations - spent));
      while (!engine->done(0)) engine->iterate();
      const NewtonEnd end = engine->unload(0, x);
      spent += end.iterations;
      tally.iterations = std::max(tally.iterations, end.iterations);
      tally.bar_visits += end.iterations * std::int64_t(part->bars().size());
      const bool resolved =
          end.reason == StopReason::within_tolerance || end.reason == StopReason::nothing_broken;
      if (end.reason == StopReason::not_finite) continue;
      if (attempt == 0) first_energy = end.energy;
      if (best.empty() || end.energy < best_energy) {
        best = x;
        best_energy = end.energy;
      }
      if (!resolved && !(attempt == shakes.size() && best_energy < better * first_energy)) continue;
      const std::vector<Vec3>& result = resolved ? x : best;
      for (std::size_t k = 0; k < free.size(); ++k) positions[std::size_t(free[k])] = result[k];
      tally.better = true;
      // tries do not need each other
      if (resolved) tally.iterations = end.iterations;
      return tally;
    }
  }
  return tally;
}

/// Joints that move within some bars of others, sorted.
std::vector<int> NewtonRepair::ball(const std::vector<int>& centre, int bars) {
  std::vector<int> found = centre;
  for (const int joint : found) local_[std::size_t(joint)] = 0;
  std::size_t begin = 0;
  for (int step = 0; step < bars && found.size() <= most_joints; ++step) {
    const std::size_t end = found.size();
    for (; begin < end; ++begin) {
      const int joint = found[begin];
      for (auto u = use_begin_[std::size_t(joint)]; u < use_begin_[std::size_t(joint) + 1]; ++u) {
        const std::int64_t k = uses_[std::size_t(u)];
        if (k >= std::int64_t(framework_->bars().size())) continue;
        const Bar& bar = framework_->bars()[std::size_t(k)];
        const int other = bar.p == joint ? bar.q : bar.p;
        if (local_[std::size_t(other)] == 0 || framework_->fixed()[std::size_t(other)]) continue;
        local_[std::size_t(other)] = 0;
        found.push_back(other);
      }
    }
  }
  for (const int joint : found) local_[std::size_t(joint)] = -1;
  std::sort(found.begin(), found.end());
  return found;
}

/// The framework of these joints, the others of their constraints fixed.
std::shared_ptr<const Framework> NewtonRepair::cut_out(const std::vector<int>& free,
                                                       std::span<const Vec3> positions,
                                                       const Box* box, std::vector<int>& joints) {
  const Framework& f = *framework_;
  FrameworkParts parts;
  joints = free;
  for (std::size_t k = 0; k < free.size(); ++k) local_[std::size_t(free[k])] = int(k);
  const auto local = [&](int joint) {
    int& number = local_[std::size_t(joint)];
    if (number < 0) {
      number = int(joints.size());
      joints.push_back(joint);
    }
    return number;
  };
  std::vector<std::int64_t> wanted;
  std::vector<int> wanted_near;
  for (const int joint : free) {
    const auto first = uses_.begin() + use_begin_[std::size_t(joint)];
    wanted.insert(wanted.end(), first, uses_.begin() + use_begin_[std::size_t(joint) + 1]);
    if (!near_.empty()) {
      const auto& list = near_of_[std::size_t(joint)];
      wanted_near.insert(wanted_near.end(), list.begin(), list.end());
    }
  }
  std::sort(wanted.begin(), wanted.end());
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  std::sort(wanted_near.begin(), wanted_near.end());
  wanted_near.erase(std::unique(wanted_near.begin(), wanted_near.end()), wanted_near.end());
  const std::int64_t bars = std::int64_t(f.bars().size()),
                     tethers = bars + std::int64_t(f.tethers().size()),
                     contacts = tethers + std::int64_t(f.contacts().size());
  for (const std::int64_t k : wanted) {
    if (k < bars) {
      Bar bar = f.bars()[std::size_t(k)];
      bar.p = local(bar.p);
      bar.q = local(bar.q);
      parts.bars.push_back(bar);
    } else if (k < tethers) {
      const Tether& t = f.tethers()[std::size_t(k - bars)];
      parts.tethers.push_back({local(t.p), local(t.q), t.length, t.kind});
    } else if (k < contacts) {
      const Contact& c = f.contacts()[std::size_t(k - tethers)];
      parts.contacts.push_back({local(c.p), local(c.q), c.length, c.kind});
    } else {
      Volume v = f.volumes()[std::size_t(k - contacts)];
      for (int* corner : {&v.a, &v.b, &v.c, &v.d}) *corner = local(*corner);
      parts.volumes.push_back(v);
    }
  }
  for (const int k : wanted_near) {
    const NearContact& pair = near_[std::size_t(k)];
    // an image's contact cannot be told without the box; the next look at the whole tells it
    const Vec3 d = positions[std::size_t(pair.q)] - positions[std::size_t(pair.p)];
    if (box && box->minimum_image(d) != d) continue;
    parts.contacts.push_back({local(pair.p), local(pair.q), pair.bound});
  }
  // a pair may be an explicit contact and one of the rule: the longer bound holds
  std::stable_sort(parts.contacts.begin(), parts.contacts.end(),
                   [](const Contact& one, const Contact& two) {
                     const auto a = std::minmax(one.p, one.q), b = std::minmax(two.p, two.q);
                     return a != b ? a < b : one.length > two.length;
                   });
  parts.contacts.erase(std::unique(parts.contacts.begin(), parts.contacts.end(),
                                   [](const Contact& one, const Contact& two) {
                                     return std::minmax(one.p, one.q) == std::minmax(two.p, two.q);
                                   }),
                       parts.contacts.end());
  for (std::size_t k = 0; k < joints.size(); ++k) {
    const std::size_t joint = std::size_t(joints[k]);
    parts.masses.push_back(f.masses()[joint]);
    parts.fixed.push_back(k >= free.size());
    local_[joint] = -1;
  }
  return std::make_shared<const Framework>(std::move(parts));
}

}  // namespace ragdoll
