#include "block_entry.h"

#include <algorithm>  // max
#include <cmath>      // isfinite
#include <limits>     // infinity

#include "ragdoll/random.h"  // Random

namespace ragdoll {
namespace {

constexpr int most_shakes = 6;

Vec3 direction(const Vec3& d) {
  const double length = d.norm();
  return length > 0 ? Vec3(d / length) : Vec3(1, 0, 0);
}

}  // namespace

Turn::Turn(const Vec3& was, const Vec3& at, const Vec3& point)
    : was_(was), at_(at), from_(direction(point - was)) {
  const Vec3 to = direction(point - at);
  axis_ = (from_ + to).squaredNorm() > 1e-20 ? direction(from_ + to) : from_.unitOrthogonal();
}

BlockEntry::BlockEntry(const Framework& framework, const BlockTree& tree)
    : framework_(framework), newton_(tree), ring_(tree.most_bars) {
  for (auto* const points : {&start_, &y_, &nearest_}) points->reserve(tree.most_joints);
  for (auto* const marks : {&pinned_, &seen_}) marks->reserve(tree.most_joints);
  in_tree_.reserve(tree.most_bars);
  queue_.reserve(tree.most_joints);
}

BlockOutcome BlockEntry::enter(int index, int entry, std::span<const Vec3> x, const Vec3* was) {
  newton_.enter(index);
  entry_ = entry;
  const std::size_t count = block().joints.size();
  start_.resize(count);
  y_.resize(count);
  for (std::size_t j = 0; j < count; ++j) start_[j] = y_[j] = x[std::size_t(block().joints[j])];
  pinned_.assign(count, 0);
  others_pinned_ = false;
  if (newton_.has_fixed_joints()) {
    for (std::size_t j = 0; j < count; ++j) {
      pinned_[j] = framework_.fixed()[std::size_t(block().joints[j])];
      others_pinned_ |= pinned_[j] != 0 && int(j) != entry;
    }
  }
  pinned_[std::size_t(entry)] = 1;

  const bool turns = was && !others_pinned_ && start_.size() <= Turn::most_joints;
  const bool dense = block().bars.size() >= 2 * block().joints.size();
  by_ring_ =
      !turns && !others_pinned_ && !block().ring.empty() && ring_.resolve(block(), entry, y_);
  if (by_ring_) return ring_.moved() ? BlockOutcome::met : BlockOutcome::whole;
  double most = turns || dense ? newton_.look(y_) : hang();
  if (!std::isfinite(most)) return BlockOutcome::not_finite;
  if (most <= 1 && (turns || dense || y_ == start_)) return BlockOutcome::whole;
  if (turns) {
    if (turn(*was)) return BlockOutcome::met;
    y_ = start_;
    by_ring_ = !block().ring.empty() && ring_.resolve(block(), entry, y_);
    if (by_ring_) return BlockOutcome::met;
    if (!dense) most = hang();
  }
  nearest_.clear();
  nearest_error_ = std::numeric_limits<double>::infinity();
  if (deform(most)) return BlockOutcome::met;
  if (carry(was)) return BlockOutcome::carried;
  for (int attempt = 0; attempt < most_shakes; ++attempt) {
    y_ = start_;
    hang();
    shake((0.1 + 0.2 * attempt) * block().mean_length, attempt);
    newton_.look(y_);
    if (newton(attempt % 2 == 0 ? 1e-2 : 1.0)) return BlockOutcome::met;
  }
  y_ = nearest_.empty() ? start_ : nearest_;
  newton_.look(y_);
  return BlockOutcome::held;
}

/// From y_, whose looks were taken.
bool BlockEntry::newton(double first_mu) {
  if (newton_.resolve(y_, pinned_, first_mu)) return true;
  const double error = newton_.look(y_);
  if (error < nearest_error_) {
    nearest_error_ = error;
    nearest_ = y_;
  }
  return false;
}

/// @param most  of the start that enter() took, which y_ holds
bool BlockEntry::deform(double most) {
  const bool hung = y_ != start_;
  if (most <= 1) {
    // the pre-pass did it; what it takes for exact may be off where numbers are large
    most = newton_.look(y_);
    if (most <= 1) return true;
  }
  if (newton(hung ? 1e-6 : 1e-2)) return true;
  y_ = start_;
  if (hung)
    newton_.look(y_);
  else
    hang();
  if (newton(hung ? 1e-2 : 1e-6)) return true;
  y_ = start_;
  share_evenly();
  newton_.look(y_);
  return newton(1e-1);
}

/// The shape in which the entry joint is where the others want it, moved as a whole. With fixed
/// joints among them it cannot be.
bool BlockEntry::carry(const Vec3* was) {
  Vec3 place;
  if (was)
    place = *was;
  else if (!find_entry(place))
    return false;
  const Vec3 by = start_[std::size_t(entry_)] - place;
  for (std::size_t j = 0; j < y_.size(); ++j) y_[j] = pinned_[j] ? start_[j] : Vec3(start_[j] + by);
  newton_.look(y_);
  return newton(1e-3);
}

/// The block as it is, its entry joint at `was`, is turned about the entry joint so that its centre
/// lies where the present one does, seen from there. @return false if it is not whole so
bool BlockEntry::turn(const Vec3& was) {
  // of the looks that were taken, those of the entry joint's bars change
  for (const CycleBlock::Link& link : block().links_of(std::size_t(entry_)))
    if (!(newton_.look_at(std::size_t(link.bar), was, y_[std::size_t(link.other)]) <= Turn::whole))
      return false;
  double per_slack = 0;
  for (std::size_t k = 0; k < block().bars.size(); ++k) {
    if (!(newton_.share(k) <= Turn::whole)) return false;
    per_slack = std::max(per_slack, block().local_bars[k].per_slack);
  }
  const Vec3 at = start_[std::size_t(entry_)];
  Vec3 centre = Vec3::Zero();
  for (std::size_t j = 0; j < y_.size(); ++j)
    if (int(j) != entry_) centre += start_[j];
  centre /= double(y_.size() - 1);
  const Turn turned(was, at, centre);
  for (std::size_t j = 0; j < y_.size(); ++j)
    if (int(j) != entry_) y_[j] = turned(start_[j]);
  const double size = at.cwiseAbs().maxCoeff() + centre.cwiseAbs().maxCoeff();
  return Turn::rounding * size * per_slack < 1 - Turn::whole || newton_.look(y_) <= 1;
}

/// Breadth-first from the entry, 1/0, along the bars by which joints are first met; then the bars
/// that are left are looked at. @return the largest violation that is left
double BlockEntry::hang() {
  const CycleBlock& at = block();
  seen_.assign(at.joints.size(), 0);
  in_tree_.assign(at.bars.size(), 0);
  seen_[std::size_t(entry_)] = 1;
  queue_.assign(1, entry_);
  double most = 0, sum = 0;
  for (std::size_t head = 0; head < queue_.size(); ++head) {
    const auto near = std::size_t(queue_[head]);
    for (const CycleBlock::Link& link : at.links_of(near)) {
      const auto far = std::size_t(link.other), bar = std::size_t(link.bar);
      if (seen_[far]) continue;
      seen_[far] = in_tree_[bar] = 1;
      queue_.push_back(link.other);
      const CycleBlock::LocalBar& local = at.local_bars[bar];
      double violation = newton_.look_at(bar, y_[std::size_t(local.p)], y_[std::size_t(local.q)]);
      sum += violation;
      if (violation > 1 && !pinned_[far]) {
        const double length = std::size_t(local.p) == near ? local.length : -local.length;
        y_[far] = y_[near] + length * newton_.unit(bar);
        newton_.straighten(bar);
        violation = 0;
      }
      most = std::max(most, violation);
    }
  }
  for (std::size_t k = 0; k < at.bars.size(); ++k) {
    if (in_tree_[k]) continue;
    const CycleBlock::LocalBar& local = at.local_bars[k];
    const double violation = newton_.look_at(k, y_[std::size_t(local.p)], y_[std::size_t(local.q)]);
    sum += violation;
    most = std::max(most, violation);
  }
  return std::isfinite(sum) ? most : std::numeric_limits<double>::infinity();
}

/// Plain .5/.5 sweeps.
void BlockEntry::share_evenly() {
  constexpr int sweeps = 20;
  for (int sweep = 0; sweep < sweeps; ++sweep)
    for (std::size_t k = 0; k < block().bars.size(); ++k) {
      const CycleBlock::LocalBar& bar = block().local_bars[k];
      const auto p = std::size_t(bar.p), q = std::size_t(bar.q);
      newton_.look_at(k, y_[p], y_[q]);
      const double share = pinned_[p] || pinned_[q] ? 1 : 0.5;
      const Vec3 move = share * newton_.error(k) * newton_.unit(k);
      if (!pinned_[p]) y_[p] += move;
      if (!pinned_[q]) y_[q] -= move;
    }
}

/// Where the others, as they are, want the entry joint: sought from where it is, from their middle,
/// and from around that. @return false if no such place is found
bool BlockEntry::find_entry(Vec3& place) {
  const auto entry = std::size_t(entry_);
  std::vector<std::uint8_t> others(start_.size(), 1);
  others[entry] = 0;
  Vec3 middle = Vec3::Zero();
  for (const CycleBlock::Link& link : block().links_of(entry))
    middle += start_[std::size_t(link.other)] / double(block().links_of(entry).size());
  std::vector<Vec3> sides = {start_[entry], middle};
  for (int i = 0; i < 3; ++i)
    for (const double sign : {1.0, -1.0})
      sides.push_back(middle + sign * block().mean_length * Vec3::Unit(i));
  for (const Vec3& side : sides) {
    y_ = start_;
    y_[entry] = side;
    newton_.look(y_);
    if (newton_.resolve(y_, others, 1e-3)) {
      place = y_[entry];
      return true;
    }
  }
  return false;
}

/// Random steps, the same for the same attempt.
void BlockEntry::shake(double size, int attempt) {
  Random random(0, RandomStream::order, std::uint64_t(attempt));
  for (std::size_t j = 0; j < y_.size(); ++j) {
    const Vec3 step(random.gaussian(), random.gaussian(), random.gaussian());
    if (!pinned_[j]) y_[j] += size * step;
  }
}

}  // namespace ragdoll
