// Lanes of `ordered`. One iteration is one pass in every lane that is busy; a lane that has ended
// is left alone until it is loaded anew, so that lanes never wait for each other. What is rare is
// done by the Resolver of one conformer, from where the lane was loaded: forced joints, whose
// orders differ from lane to lane, positions that are no numbers, violated constraints between
// fixed joints, contacts of joints that fly about.

#include "ensemble_ordered.h"

#include <hwy/aligned_allocator.h>  // AllocateAligned

#include <algorithm>  // copy, fill, max, none_of
#include <utility>    // move

#include "lane_sweep.h"      // LaneKernels, LaneSweep
#include "near_contacts.h"   // NearContacts
#include "ordered_passes.h"  // OrderedOutcome, conclude_passes
#include "pass_frame.h"      // PassFrame
#include "ragdoll/random.h"  // Random
#include "strided_points.h"  // StridedPoints

namespace ragdoll {
namespace {

template <class T>
class OrderedEnsemble final : public EnsembleResolver {
 public:
  OrderedEnsemble(std::shared_ptr<const Framework> framework, const ResolverSettings& settings,
                  int lanes, std::unique_ptr<Resolver> alone)
      : framework_(std::move(framework)),
        settings_(settings),
        joints_(std::size_t(framework_->joint_count())),
        kernels_(lane_kernels<T>()),
        constraints_(*framework_, settings),
        alone_(std::move(alone)),
        lanes_(lanes > 0 ? std::size_t(lanes) : kernels_.vector * vectors()),
        width_((lanes_ + kernels_.vector - 1) / kernels_.vector * kernels_.vector),
        x_(zeros(3 * joints_ * width_)),
        flags_(zeros(7 * width_)) {
    SweepOrder sweep_order(*framework_, settings);
    Random random(settings.seed, RandomStream::order, 0);
    Order order;
    sweep_order.prepare({}, random, order);
    constraints_.set_order(order, sweep_order);
    const bool contacts = !framework_->contact_rule().empty();
    looked_up_at_ = zeros(contacts ? x_count() : 0);
    const std::shared_ptr<ContactList> list = near_contact_list(*framework_);
    for (std::size_t k = 0; k < lanes_; ++k)
      lane_.emplace_back(*framework_, settings.tolerance, constraints_.slack, list,
                         contacts ? points_of(looked_up_at_, k) : StridedPoints<T>{});
  }

  int lanes() const override { return int(lanes_); }
  std::size_t joint_count() const override { return joints_; }
  std::string instructions() const override { return kernels_.instructions; }
  std::string solver() const override { return alone_->solver(); }

  void load(int index, std::span<const Vec3> positions, const Breakage& breakage) override {
    Lane& lane = lane_[std::size_t(index)];
    lane.start.assign(positions.begin(), positions.end());
    lane.breakage = breakage;
    lane.outcome = {};
    lane.state = State::alone;
    if (!breakage.roots.empty() && settings_.custom_order.empty()) return;
    if (!lane.frame.centre(positions)) return;
    lane.near_contacts.begin(breakage.box);
    lane.state = State::busy;
    loaded_.push_back(std::size_t(index));
  }

  void iterate() override {
    put_loaded();
    if (std::none_of(busy(), busy() + lanes_, [](T flag) { return flag != 0; })) return;
    std::fill(corrected(), not_finite() + width_, T(0));
    const LaneSweep<T> sweep = {&constraints_, x_.get(), width_,      busy(),
                                corrected(),   held(),   not_finite()};
    kernels_.bars_and_pairs(sweep);
    if (!framework_->contact_rule().empty()) sweep_contacts();
    kernels_.volumes(sweep);
    for (std::size_t k = 0; k < lanes_; ++k)
      if (busy()[k] != 0) end_pass(k);
  }

  bool done(int lane) const override { return lane_[std::size_t(lane)].state != State::busy; }

  ResolveReport unload(int index, std::span<Vec3> positions) override {
    Lane& lane = lane_[std::size_t(index)];
    const StridedPoints<T> points = points_of(x_, std::size_t(index));
    std::copy(lane.start.begin(), lane.start.end(), positions.begin());
    if (lane.state == State::alone) return alone_->resolve(positions, lane.breakage);
    ResolveReport report;
    const std::span<const NearPair> near = lane.near_contacts.pairs(points);
    if (lane.outcome.reason == StopReason::max_iterations &&
        within_tolerance(*framework_, points, lane.breakage.box, settings_.tolerance, near))
      lane.outcome.reason = StopReason::within_tolerance;
    lane.frame.take(points, positions);
    if (conclude_passes<T>(report, lane.outcome, *framework_, positions, lane.breakage.box,
                           settings_.tolerance, near))
      return report;
    std::copy(lane.start.begin(), lane.start.end(), positions.begin());
    return alone_->resolve(positions, lane.breakage);
  }

 private:
  /// alone: left to the single resolver
  enum class State { free, busy, ended, alone };

  struct Lane {
    Lane(const Framework& framework, const Tolerance& tolerance, const Slack<T>& slack,
         std::shared_ptr<ContactList> list, StridedPoints<T> looked_up_at)
        : frame(framework, tolerance),
          near_contacts(framework, slack, std::move(list), looked_up_at) {}

    State state = State::free;
    std::vector<Vec3> start;  ///< as loaded (njoint)
    Breakage breakage;
    OrderedOutcome outcome;
    PassFrame<T> frame;
    NearContacts<T> near_contacts;
    std::int64_t watched = 0;  ///< the look-up whose pairs are watched
  };

  /// Two vectors hide each other's waiting, as long as the nearer caches hold the positions.
  std::size_t vectors() const {
    constexpr std::size_t near_cache = std::size_t(1) << 20;
    return 2 * kernels_.vector * 3 * joints_ * sizeof(T) <= near_cache ? 2 : 1;
  }

  using Array = hwy::AlignedFreeUniquePtr<T[]>;

  static Array zeros(std::size_t count) {
    Array array = hwy::AllocateAligned<T>(std::max<std::size_t>(count, 1));
    std::fill(array.get(), array.get() + count, T(0));
    return array;
  }
  std::size_t x_count() const { return 3 * joints_ * width_; }

  StridedPoints<T> points_of(const Array& array, std::size_t lane) const {
    return {array.get() + lane, joints_, 3 * width_, width_};
  }

  /// Lanes that were loaded since the last iteration, together: they lie in the same cache lines.
  void put_loaded() {
    for (std::size_t j = 0; j < joints_ && !loaded_.empty(); ++j)
      for (const std::size_t k : loaded_)
        lane_[k].frame.put(lane_[k].start[j], points_of(x_, k), int(j));
    for (const std::size_t k : loaded_) busy()[k] = 1;
    loaded_.clear();
  }

  // one number a lane each, side by side
  T* busy() const { return flags_.get(); }
  T* corrected() const { return busy() + width_; }
  T* held() const { return corrected() + width_; }
  T* not_finite() const { return held() + width_; }
  T* furthest2() const { return not_finite() + width_; }
  T* in_contact() const { return furthest2() + width_; }  ///< and no box
  T* suspects() const { return in_contact() + width_; }

  // === Contacts of the rule

  void sweep_contacts() {
    kernels_.furthest(x_.get(), looked_up_at_.get(), joints_, width_, furthest2());
    for (std::size_t k = 0; k < lanes_; ++k) {
      in_contact()[k] = 0;
      if (busy()[k] == 0 || not_finite()[k] != 0) continue;
      constexpr double room = NearContacts<T>::room * (1 - 1e-5);  // but for rounding
      NearContacts<T>& contacts = lane_[k].near_contacts;
      PassTally tally;
      if (lane_[k].breakage.box) {
        contacts.sweep(points_of(x_, k), tally);
      } else {
        const bool holds = contacts.looked_up() && double(furthest2()[k]) < room * room;
        in_contact()[k] = contacts.start_pass(points_of(x_, k), holds, tally);
        if (lane_[k].watched != contacts.look_ups()) watch(lane_[k]);
      }
      note(k, tally);
    }
    sweep_watched();
  }

  /// The pairs that could be violated in some lane, in all lanes at once. Each lane corrects its
  /// own by itself.
  void sweep_watched() {
    const LaneSweep<T> sweep = {&constraints_, x_.get(), width_,      in_contact(),
                                corrected(),   held(),   not_finite()};
    std::size_t place = 0;
    while (true) {
      place = kernels_.next_contact(sweep, watched_.data(), place, watched_.size(), suspects());
      if (place == watched_.size()) return;
      const NearPair pair = {watched_[place].p, watched_[place].q, watched_[place].bound};
      bool renewed = false;
      for (std::size_t k = 0; k < lanes_; ++k) {
        if (suspects()[k] == 0) continue;
        PassTally tally;
        if (lane_[k].near_contacts.visit(points_of(x_, k), pair, tally)) {
          watch(lane_[k]);
          renewed = true;
        }
        note(k, tally);
      }
      place = renewed ? NearContacts<T>::place_behind(watched_, pair) : place + 1;
    }
  }

  void note(std::size_t lane, const PassTally& tally) {
    if (tally.corrections > 0) corrected()[lane] = 1;
    if (tally.held > 0) held()[lane] = 1;
    if (!tally.finite || lane_[lane].near_contacts.scattered()) {
      not_finite()[lane] = 1;
      in_contact()[lane] = 0;
    }
  }

  /// Adds a lane's pairs to those that are watched. When these have become many, the ones that no
  /// lane needs are left out.
  void watch(Lane& lane) {
    merge(lane.near_contacts.near());
    lane.watched = lane.near_contacts.look_ups();
    if (watched_.size() < watched_limit_) return;
    watched_.clear();
    for (Lane& each : lane_) {
      merge(each.near_contacts.near());
      each.watched = each.near_contacts.look_ups();
    }
    watched_limit_ = 2 * watched_.size() + 1000;
  }

  void merge(const std::vector<NearPair>& near) {
    merged_.clear();
    auto old = watched_.begin();
    for (const NearPair& pair : near) {
      while (old != watched_.end() && (old->p < pair.p || (old->p == pair.p && old->q < pair.q)))
        merged_.push_back(*old++);
      if (old != watched_.end() && old->p == pair.p && old->q == pair.q) {
        merged_.push_back(*old++);
        continue;
      }
      const double sure = std::max(0.0, pair.bound - double(constraints_.slack.of(pair.bound))) *
                          (1 + Slack<T>::hair);
      merged_.push_back({pair.p, pair.q, T(sure * sure), pair.bound});
    }
    merged_.insert(merged_.end(), old, watched_.end());
    watched_.swap(merged_);
  }

  /// What the loop of OrderedPasses does behind a pass.
  void end_pass(std::size_t k) {
    Lane& lane = lane_[k];
    OrderedOutcome& outcome = lane.outcome;
    if (not_finite()[k] != 0 || held()[k] != 0) {
      lane.state = State::alone;
    } else if (corrected()[k] == 0) {
      outcome.reason =
          outcome.iterations == 0 ? StopReason::nothing_broken : StopReason::within_tolerance;
      // a custom order may leave bars out
      lane.state = settings_.custom_order.empty() ? State::ended : State::alone;
    } else {
      ++outcome.iterations;
      outcome.bar_visits += std::int64_t(constraints_.bars.size());
      if (outcome.iterations == settings_.max_iterations) {
        outcome.reason = StopReason::max_iterations;
        lane.state = State::ended;
      }
    }
    if (lane.state != State::busy) busy()[k] = 0;
  }

  std::shared_ptr<const Framework> framework_;
  ResolverSettings settings_;
  std::size_t joints_;
  const LaneKernels<T>& kernels_;
  OrderedConstraints<T> constraints_;
  std::unique_ptr<Resolver> alone_;
  std::size_t lanes_, width_;  ///< width_: with the padding
  Array x_, looked_up_at_;     ///< (njoint, 3, width_)
  Array flags_;                ///< (7, width_)
  std::vector<Lane> lane_;
  std::vector<std::size_t> loaded_;  ///< lanes that wait to be put in place

  std::vector<NearVisit<T>> watched_, merged_;  ///< sorted; merged_: scratch
  std::size_t watched_limit_ = 0;
};

}  // namespace

bool ordered_lanes_fit(const ResolverSettings& settings) {
  if (settings.work_list) return false;
  if (!settings.custom_order.empty()) return true;
  switch (settings.order) {
    case OrderKind::bfs_tree:
    case OrderKind::dfs_tree:
    case OrderKind::bfs_cycle:
    case OrderKind::dfs_cycle:
    case OrderKind::bfs_reverse:
    case OrderKind::dfs_reverse:
      return true;
    default:
      return false;
  }
}

std::unique_ptr<EnsembleResolver> make_ordered_ensemble(std::shared_ptr<const Framework> framework,
                                                        const ResolverSettings& settings, int lanes,
                                                        std::unique_ptr<Resolver> alone) {
  if (settings.precision == Precision::single)
    return std::make_unique<OrderedEnsemble<float>>(std::move(framework), settings, lanes,
                                                    std::move(alone));
  return std::make_unique<OrderedEnsemble<double>>(std::move(framework), settings, lanes,
                                                   std::move(alone));
}

}  // namespace ragdoll
