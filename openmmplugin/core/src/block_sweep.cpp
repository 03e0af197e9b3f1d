#include "block_sweep.h"

#include <algorithm>  // max
#include <cmath>      // abs, isfinite
#include <limits>     // min

#include "ragdoll/random.h"  // Random

namespace ragdoll {
namespace {

constexpr int nowhere = std::numeric_limits<int>::min();

Vec3 direction(const Vec3& d, double distance) {
  return distance > 0 ? Vec3(d / distance) : Vec3(1, 0, 0);
}

}  // namespace

BlockSweep::BlockSweep(const Framework& framework, double tolerance)
    : framework_(framework),
      tolerance_(tolerance),
      tree_(framework),
      newtons_(tree_.blocks.size()),
      entered_(tree_.blocks.size(), 0),
      residual_(framework.bars().size()) {}

BlockSweep::Tally BlockSweep::sweep(std::span<Vec3> x, std::span<const Vec3> resolved, int root,
                                    Scope scope) {
  x_ = x;
  resolved_ = resolved;
  scope_ = scope;
  tally_ = {};
  moved_.clear();
  ++sweeps_;
  front_.assign(1, {root, nowhere});
  for (std::size_t head = 0; head < front_.size() && tally_.finite; ++head) {
    const Front at = front_[head];
    for (const Graph::Link& link : framework_.graph().links(at.joint)) {
      const int block = tree_.block_of_bar[std::size_t(link.bar)];
      if (block < 0) {
        if (at.from == ~link.bar) continue;
        if (cross_bridge(link.bar, at.joint, link.other) || scope_ == Scope::all)
          front_.push_back({link.other, ~link.bar});
      } else if (entered_[std::size_t(block)] != sweeps_) {
        entered_[std::size_t(block)] = sweeps_;
        enter_block(block, at.joint);
      }
    }
  }
  return tally_;
}

/// 1/0: the far end takes the whole correction. @return true if it moved
bool BlockSweep::cross_bridge(int bar, int near, int far) {
  ++tally_.visits;
  const double length = framework_.bars()[std::size_t(bar)].length;
  const Vec3& p = x_[std::size_t(near)];
  Vec3& q = x_[std::size_t(far)];
  const Vec3 d = q - p;
  const double distance = d.norm();
  const double error = std::abs(distance - length);
  if (!std::isfinite(distance)) tally_.finite = false;
  if (error <= tolerance_ * length || !tally_.finite) {
    residual_.set(std::size_t(bar), error / length);
    return false;
  }
  if (framework_.fixed()[std::size_t(far)]) {
    residual_.set(std::size_t(bar), error / length);
    ++tally_.held;
    return false;
  }
  q = p + length * direction(d, distance);
  residual_.set(std::size_t(bar), std::abs((q - p).norm() - length) / length);
  ++tally_.corrections;
  move(far);
  return true;
}

void BlockSweep::enter_block(int index, int entry) {
  const CycleBlock& block = tree_.blocks[std::size_t(index)];
  std::unique_ptr<BlockNewton>& newton = newtons_[std::size_t(index)];
  if (!newton) newton = std::make_unique<BlockNewton>(block, tolerance_);
  start_.clear();
  for (const int joint : block.joints) start_.push_back(x_[std::size_t(joint)]);

  const std::int64_t visits_before = newton->visits;
  const double largest = newton->worst(start_);
  if (!std::isfinite(largest)) tally_.finite = false;
  const bool broken = tally_.finite && largest > tolerance_;
  if (broken)
    ++(resolve_block(block, *newton, block.local(entry)) ? tally_.corrections : tally_.held);
  tally_.visits += newton->visits - visits_before;
  for (std::size_t k = 0; k < block.bars.size(); ++k)
    residual_.set(std::size_t(block.bars[k]), newton->violation(k));

  for (std::size_t j = 0; j < block.joints.size(); ++j) {
    const int joint = block.joints[j];
    const bool moves = broken && start_[j] != y_[j];
    if (moves) {
      x_[std::size_t(joint)] = y_[j];
      move(joint);
    }
    if (joint != entry && (moves || scope_ == Scope::all)) front_.push_back({joint, index});
  }
}

/// Newton from the 1/0 pre-pass; where it stops short, from other starts, the same each time.
/// @return true if y_ holds positions within tolerance, else the nearest that were found
bool BlockSweep::resolve_block(const CycleBlock& block, BlockNewton& newton, int entry) {
  pinned_.clear();
  for (const int joint : block.joints) pinned_.push_back(framework_.fixed()[std::size_t(joint)]);
  pinned_[std::size_t(entry)] = 1;

  std::vector<Vec3> nearest;
  double nearest_error = std::numeric_limits<double>::infinity();
  const auto tried = [&](double mu) {
    const bool met = newton.resolve(y_, pinned_, mu);
    if (met) return true;
    const double error = newton.worst(y_);
    if (!(error < nearest_error)) return false;
    nearest_error = error;
    nearest = y_;
    return false;
  };
  const auto from = [&](double mu, auto&& prepare) {
    y_ = start_;
    prepare();
    return tried(mu);
  };
  const auto from_resolved = [&] {
    // as it was when all was well, carried to where its entry joint is now
    const Vec3 carry =
        start_[std::size_t(entry)] - resolved_[std::size_t(block.joints[std::size_t(entry)])];
    for (std::size_t j = 0; j < y_.size(); ++j)
      if (!pinned_[j]) y_[j] = resolved_[std::size_t(block.joints[j])] + carry;
  };
  bool met = from(1e-6, [&] { hang_from_entry(block, entry); }) || from(1e-2, [] {}) ||
             from(1e-1, [&] { share_evenly(block); }) ||
             from(1e-3, [&] { place_entry(newton, entry); }) ||
             (!resolved_.empty() && from(1e-3, from_resolved));
  for (int attempt = 0; attempt < 6 && !met; ++attempt)
    met = from(attempt % 2 == 0 ? 1e-2 : 1.0, [&] {
      hang_from_entry(block, entry);
      shake((0.1 + 0.2 * attempt) * block.mean_length, attempt);
    });
  if (!met) {
    y_ = nearest.empty() ? start_ : nearest;
    newton.worst(y_);
  }
  return met;
}

/// Breadth-first from the entry, 1/0, along the bars by which joints are first met.
void BlockSweep::hang_from_entry(const CycleBlock& block, int entry) {
  seen_.assign(block.joints.size(), 0);
  seen_[std::size_t(entry)] = 1;
  queue_.assign(1, entry);
  for (std::size_t head = 0; head < queue_.size(); ++head) {
    const auto near = std::size_t(queue_[head]);
    for (int k = block.link_begin[near]; k < block.link_begin[near + 1]; ++k) {
      const CycleBlock::Link link = block.links[std::size_t(k)];
      const auto far = std::size_t(link.other);
      if (seen_[far]) continue;
      seen_[far] = 1;
      queue_.push_back(link.other);
      if (pinned_[far]) continue;
      ++tally_.visits;
      const double length = block.local_bars[std::size_t(link.bar)].length;
      const Vec3 d = y_[far] - y_[near];
      const double distance = d.norm();
      if (std::abs(distance - length) > tolerance_ * length)
        y_[far] = y_[near] + length * direction(d, distance);
    }
  }
}

/// Plain .5/.5 sweeps.
void BlockSweep::share_evenly(const CycleBlock& block) {
  constexpr int sweeps = 20;
  for (int sweep = 0; sweep < sweeps; ++sweep)
    for (const auto& bar : block.local_bars) {
      const auto p = std::size_t(bar.p), q = std::size_t(bar.q);
      const Vec3 d = y_[q] - y_[p];
      const double distance = d.norm();
      const Vec3 move = (distance - bar.length) * direction(d, distance);
      const double share = pinned_[p] || pinned_[q] ? 1 : 0.5;
      if (!pinned_[p]) y_[p] += share * move;
      if (!pinned_[q]) y_[q] -= share * move;
    }
  tally_.visits += sweeps * std::int64_t(block.local_bars.size());
}

/// The entry joint is put where the others want it, and all are then carried back with it. With
/// fixed joints among them they cannot be carried.
void BlockSweep::place_entry(BlockNewton& newton, int entry) {
  std::vector<std::uint8_t> others(y_.size(), 1);
  others[std::size_t(entry)] = 0;
  for (const double offset : {0.0, 1.0}) {
    // twice: from where it is, and from the middle of the others
    if (offset != 0) {
      Vec3 sum = Vec3::Zero();
      for (std::size_t j = 0; j < y_.size(); ++j)
        if (int(j) != entry) sum += y_[j];
      y_[std::size_t(entry)] = sum / double(y_.size() - 1);
    }
    if (newton.resolve(y_, others, 1e-3)) break;
  }
  const Vec3 carry = start_[std::size_t(entry)] - y_[std::size_t(entry)];
  for (std::size_t j = 0; j < y_.size(); ++j)
    if (!pinned_[j]) y_[j] += carry;
  y_[std::size_t(entry)] = start_[std::size_t(entry)];
}

/// Random steps, the same for the same attempt.
void BlockSweep::shake(double size, int attempt) {
  Random random(0, RandomStream::order, std::uint64_t(attempt));
  for (std::size_t j = 0; j < y_.size(); ++j) {
    const Vec3 step(random.gaussian(), random.gaussian(), random.gaussian());
    if (!pinned_[j]) y_[j] += size * step;
  }
}

}  // namespace ragdoll
