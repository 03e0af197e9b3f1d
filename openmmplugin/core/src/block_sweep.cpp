#include "block_sweep.h"

#include <algorithm>  // min, max
#include <cmath>      // abs, sqrt, isfinite
#include <limits>     // min

namespace ragdoll {
namespace {

constexpr int nowhere = std::numeric_limits<int>::min();

}  // namespace

BlockSweep::BlockSweep(const Framework& framework, const Tolerance& tolerance)
    : framework_(framework),
      tolerance_(tolerance),
      tree_(framework, tolerance),
      entry_(framework, tree_),
      entered_(std::size_t(tree_.block_count()), 0),
      residual_(framework.bars().size()) {
  // what a break moves most often fits, so that it costs no allocation
  front_.reserve(256);
  moved_.reserve(256);
}

BlockSweep::Tally BlockSweep::sweep(std::span<Vec3> x, int root, Scope scope) {
  x_ = x;
  scope_ = scope;
  tally_ = {};
  moved_.clear();
  ++sweeps_;
  front_.assign(1, {root, nowhere, -1});
  if (scope == Scope::moved) fetch_around(root);
  for (std::size_t head = 0; head < front_.size() && tally_.finite; ++head) {
    const Front at = front_[head];
    for (const BlockTree::Way& way : tree_.ways(at.joint)) {
      if (way.bar >= 0) {
        if (at.from != ~way.bar) cross_bridge(way, at.joint);
      } else if (entered_[std::size_t(~way.bar)] != sweeps_) {
        entered_[std::size_t(~way.bar)] = sweeps_;
        enter_block(~way.bar, way.to, at);
      }
    }
  }
  return tally_;
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

/// 1/0: the far end takes the whole correction.
void BlockSweep::cross_bridge(const BlockTree::Way& bridge, int near) {
  ++tally_.visits;
  const double length = bridge.length, slack = tolerance_.slack(length);
  const Vec3& p = x_[std::size_t(near)];
  Vec3& q = x_[std::size_t(bridge.to)];
  const Vec3 d = q - p;
  const double distance = std::sqrt(d.squaredNorm());
  double error = std::abs(distance - length);
  if (!std::isfinite(distance)) {
    tally_.finite = false;
    return;
  }
  bool moves = error > slack;
  if (moves && framework_.fixed()[std::size_t(bridge.to)]) {
    ++tally_.held;
    moves = false;
  } else if (moves) {
    moved_.push_back({bridge.to, q});
    q = distance > 0 ? Vec3(p + length / distance * d) : Vec3(p + Vec3(length, 0, 0));
    error = std::abs((q - p).norm() - length);
    // far from the origin numbers may be too coarse for the tolerance
    ++(error <= slack ? tally_.corrections : tally_.held);
  }
  residual_.set(std::size_t(bridge.bar), {error / length, error});
  if (moves || scope_ == Scope::all) front_.push_back({bridge.to, ~bridge.bar, last_moved(moves)});
}

void BlockSweep::enter_block(int index, int entry, const Front& at) {
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
    if (moves || scope_ == Scope::all) front_.push_back({joint, index, last_moved(moves)});
  }
}

}  // namespace ragdoll
