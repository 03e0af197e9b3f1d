#include "block_sweep.h"

#include <algorithm>  // min, max, all_of
#include <cmath>      // abs, sqrt, isfinite
#include <limits>     // min

namespace ragdoll {
namespace {

constexpr int nowhere = std::numeric_limits<int>::min();
constexpr std::size_t most_at_hand = 1000;  ///< joints of structures that the caches hold anyway

}  // namespace

BlockSweep::BlockSweep(const Framework& framework, const Tolerance& tolerance)
    : framework_(framework),
      tolerance_(tolerance),
      tree_(framework, tolerance),
      entry_(framework, tree_),
      entered_(std::size_t(tree_.block_count()), 0),
      turned_(entered_.size(), 0),
      residual_(framework.bars().size()) {
  // what a break moves most often fits, so that it costs no allocation
  front_.resize(256);
  moved_.reserve(256);
}

BlockSweep::Tally BlockSweep::sweep(std::span<Vec3> x, int root, Scope scope) {
  x_ = x;
  scope_ = scope;
  tally_ = {};
  moved_.clear();
  ++sweeps_;
  reached_ = 0;
  reach(root, nowhere, -1);
  if (scope == Scope::moved) {
    if (x.size() > most_at_hand) fetch_around(root);
    go_outward<Scope::moved>();
  } else {
    go_outward<Scope::all>();
  }
  return tally_;
}

/// Bridges are 1/0: the far end takes the whole correction. In plain numbers, one after the other:
/// that is what most of the time goes into.
template <BlockSweep::Scope scope>
void BlockSweep::go_outward() {
  double* const x = x_.data()->data();
  const std::uint8_t* const fixed = framework_.fixed().data();
  std::int64_t visits = 0, corrections = 0;
  for (std::size_t head = 0; head < reached_; ++head) {
    const Front at = front_[head];
    const double* const p = x + 3 * std::ptrdiff_t(at.joint);
    for (const BlockTree::Way& way : tree_.ways(at.joint)) {
      if (way.bar < 0) {
        if (entered_[std::size_t(~way.bar)] == sweeps_) continue;
        entered_[std::size_t(~way.bar)] = sweeps_;
        enter_block(~way.bar, way.to, at);
        if (tally_.finite) continue;
        return;
      }
      if (at.from == ~way.bar) continue;
      ++visits;
      double* const q = x + 3 * std::ptrdiff_t(way.to);
      const double length = way.length, slack = tolerance_.slack(length), inverse = 1 / length;
      const double px = p[0], py = p[1], pz = p[2], qx = q[0], qy = q[1], qz = q[2];
      double dx = qx - px, dy = qy - py, dz = qz - pz;
      const double distance = std::sqrt(dx * dx + dy * dy + dz * dz);
      double error = std::abs(distance - length);
      if (error <= slack) {
        residual_.set(std::size_t(way.bar), {error * inverse, error});
        if (scope == Scope::all) reach(way.to, ~way.bar, -1);
        continue;
      }
      if (!std::isfinite(distance)) {
        tally_.finite = false;
        return;
      }
      if (fixed[way.to]) {
        ++tally_.held;
        residual_.set(std::size_t(way.bar), {error * inverse, error});
        if (scope == Scope::all) reach(way.to, ~way.bar, -1);
        continue;
      }
      moved_.push_back({way.to, {qx, qy, qz}});
      if (!(distance > 0)) dx = 1;
      const double scale = distance > 0 ? length / distance : length;
      const double nx = px + scale * dx, ny = py + scale * dy, nz = pz + scale * dz;
      q[0] = nx, q[1] = ny, q[2] = nz;
      dx = nx - px, dy = ny - py, dz = nz - pz;
      const double square = dx * dx + dy * dy + dz * dz;
      error = std::abs(square - length * length) * (0.5 * inverse);
      if (error > 1e-3 * slack) {
        // far from the origin numbers may be too coarse for the tolerance
        error = std::abs(std::sqrt(square) - length);
        if (!(error <= slack)) ++tally_.held, --corrections;
      }
      ++corrections;
      residual_.set(std::size_t(way.bar), {error * inverse, error});
      reach(way.to, ~way.bar, last_moved(true));
    }
  }
  tally_.visits += visits;
  tally_.corrections += corrections;
}

/// In a large structure nothing that a forced joint moves is in the cache. Mostly it has numbers
/// close to the joint's: all of it is asked for at once, instead of line after line on the way.
void BlockSweep::fetch_around(int joint) const {
  constexpr int joints = 20, bars = 16;
  const int from = std::max(joint - joints, 0);
  const int to = std::min(joint + joints, framework_.joint_count() - 1);
  for (int j = from; j <= to; j += 2) __builtin_prefetch(&x_[std::size_t(j)]);
  tree_.fetch(from, joint, to);
  __builtin_prefetch(&framework_.fixed()[std::size_t(joint)]);
  for (const BlockTree::Way& way : tree_.ways(joint))
    if (way.bar >= 0) return residual_.fetch(std::size_t(std::max(way.bar - bars, 0)), 2 * bars);
}

/// What BlockEntry does first for a small block whose entry joint alone moved, where it is known
/// how far the bars are violated: where that joint's bars are, it turns as it is, and all stay so.
bool BlockSweep::turn_block(int index, int entry, const Vec3 was) {
  constexpr double unnoticed = 1e-3;  ///< share of the tolerance
  const std::span<const int> joints = tree_.joints_of(index), bars = tree_.bars_of(index);
  if (joints.size() > Turn::most_joints || tree_.has_fixed_joints(index)) return false;
  const CycleBlock::LocalBar* const local = tree_.local_bars_of(index).data();
  double per_slack = 0, most = 0;
  for (std::size_t k = 0; k < bars.size(); ++k) {
    per_slack = std::max(per_slack, local[k].per_slack);
    most = std::max(most, residual_.at(std::size_t(bars[k])).nanometers * local[k].per_slack);
  }
  const Vec3 at = x_[std::size_t(joints[std::size_t(entry)])];
  Vec3 centre = Vec3::Zero();
  for (std::size_t j = 0; j < joints.size(); ++j)
    if (int(j) != entry) centre += x_[std::size_t(joints[j])];
  centre /= double(joints.size() - 1);
  double& turned = turned_[std::size_t(index)];
  turned += Turn::rounding * (at.cwiseAbs().maxCoeff() + centre.cwiseAbs().maxCoeff());
  // also where one of them is no number
  if (!(most <= Turn::whole && turned * per_slack <= unnoticed)) return false;
  const std::span<const CycleBlock::Link> links = tree_.links_of(index, entry);
  tally_.visits += std::int64_t(links.size());
  const auto violation = [&](const CycleBlock::Link& link) {
    const Vec3& other = x_[std::size_t(joints[std::size_t(link.other)])];
    return std::abs((other - at).norm() - local[link.bar].length);
  };
  if (std::all_of(links.begin(), links.end(), [&](const CycleBlock::Link& link) {
        return violation(link) * local[link.bar].per_slack <= 1;
      })) {
    for (const CycleBlock::Link& link : links) {
      const double error = violation(link);
      residual_.set(std::size_t(bars[std::size_t(link.bar)]),
                    {error / local[link.bar].length, error});
    }
    return true;
  }
  ++tally_.corrections;
  const Turn turn(was, at, centre);
  for (std::size_t j = 0; j < joints.size(); ++j) {
    if (int(j) == entry) continue;
    Vec3& x = x_[std::size_t(joints[j])];
    moved_.push_back({joints[j], x});
    x = turn(x);
    reach(joints[j], index, last_moved(true));
  }
  return true;
}

void BlockSweep::enter_block(int index, int entry, const Front& at) {
  if (scope_ == Scope::moved && at.moved >= 0 &&
      turn_block(index, entry, moved_[std::size_t(at.moved)].was))
    return;
  turned_[std::size_t(index)] = 0;
  const std::int64_t visits_before = entry_.visits();
  const BlockOutcome outcome =
      entry_.enter(index, entry, x_, at.moved < 0 ? nullptr : &moved_[std::size_t(at.moved)].was);
  tally_.visits += entry_.visits() - visits_before;
  switch (outcome) {
    case BlockOutcome::whole:
      break;
    case BlockOutcome::met:
      ++tally_.corrections;
      break;
    case BlockOutcome::carried:
      ++tally_.corrections;
      ++tally_.carried;
      break;
    case BlockOutcome::held:
      ++tally_.held;
      break;
    case BlockOutcome::not_finite:
      tally_.finite = false;
      return;
  }
  const CycleBlock& block = entry_.block();
  for (std::size_t k = 0; k < block.bars.size(); ++k)
    residual_.set(std::size_t(block.bars[k]), entry_.violation(k));
  if (outcome == BlockOutcome::whole && scope_ == Scope::moved) return;
  for (std::size_t j = 0; j < block.joints.size(); ++j) {
    const int joint = block.joints[j];
    if (int(j) == entry) continue;
    const Vec3& before = entry_.before()[j];
    const Vec3& after = entry_.after()[j];
    const bool moves = outcome != BlockOutcome::whole && before != after;
    if (moves) {
      x_[std::size_t(joint)] = after;
      moved_.push_back({joint, before});
    }
    if (moves || scope_ == Scope::all) reach(joint, index, last_moved(moves));
  }
}

}  // namespace ragdoll
