#include "newton_bars.h"

#include <algorithm>  // any_of, fill, max, min
#include <cmath>      // isfinite
#include <limits>     // infinity

#include "lane_transfer.h"     // copy_and_survey, put_lanes, take_lanes, place_row
#include "sweep_arithmetic.h"  // Slack

namespace ragdoll {

template <class T>
NewtonBars<T>::NewtonBars(std::shared_ptr<const NewtonBarsPlan> plan, const Framework& framework,
                          const Tolerance& tolerance, bool wide)
    : plan_(std::move(plan)),
      kernel_(newton_bars_kernel<T>(wide)),
      tolerance_(tolerance),
      lanes_(kernel_.lanes, Lane(PassFrame<T>(framework, tolerance))) {
  // of a pivot, where bars that others make redundant leave nothing
  constexpr double hair = Slack<T>::single ? 1e-6 : 1e-12;
  const Slack<T> slack(tolerance);
  double mean = 0;
  bars_.reserve(plan_->bars.size());
  for (const NewtonBarsPlan::BarRow& bar : plan_->bars) {
    bars_.push_back({bar.p, bar.q, T(bar.length), T(1 / bar.length),
                     T(1 / double(slack.of(bar.length))), T(bar.near_weight), T(bar.far_weight),
                     T(bar.near_weight + bar.far_weight)});
    mean +=
        bar.length * bar.length * (bar.near_weight + bar.far_weight) / double(plan_->bars.size());
  }
  entries_.reserve(plan_->entries.size());
  for (const NewtonBarsPlan::Entry& entry : plan_->entries)
    entries_.push_back({entry.row, entry.column, T(entry.coupling)});
  is_taken_from_.resize(entries_.size());
  for (const int target : plan_->targets)
    if (target >= int(bars_.size())) is_taken_from_[std::size_t(target) - bars_.size()] = 1;
  for (std::size_t e = 0; e < entries_.size(); ++e)
    if (is_taken_from_[e]) taken_from_.push_back(int(e));
  const std::size_t bars = bars_.size();
  x_ = zeros(3 * plan_->joint_count);
  d_ = zeros(3 * bars);
  value_ = zeros(bars + entries_.size());
  z_ = zeros(bars);
  busy_ = zeros(1);
  worst_ = zeros(1);
  relative_ = zeros(1);
  largest_ = zeros(1);
  sum_ = zeros(1);
  wanted_ = zeros(1);
  if (Slack<T>::single) {
    relative_from_ = zeros(1);
    largest_from_ = zeros(1);
    rows_ = zeros(3 * plan_->joint_count);
    for (const NewtonBarsPlan::BarRow& bar : plan_->bars) {
      longest_ = std::max(longest_, bar.length);
      lengths_.push_back(bar.length);
      lengths_.push_back(1 / bar.length);
    }
    exact_relative_.resize(kernel_.lanes);
    exact_largest_.resize(kernel_.lanes);
  }
  task_ = {bars,
           entries_.size(),
           bars_.data(),
           entries_.data(),
           plan_->begin.data(),
           plan_->targets.data(),
           taken_from_.size(),
           taken_from_.data(),
           is_taken_from_.data(),
           T(std::max(mean * hair, 1e-30)),
           x_.get(),
           d_.get(),
           value_.get(),
           z_.get(),
           busy_.get(),
           worst_.get(),
           relative_.get(),
           largest_.get(),
           sum_.get(),
           lengths_.data(),
           relative_from_.get(),
           largest_from_.get(),
           exact_relative_.data(),
           exact_largest_.data()};
}

template <class T>
typename NewtonBars<T>::Array NewtonBars<T>::zeros(std::size_t vectors) const {
  Array array = hwy::AllocateAligned<T>(std::max<std::size_t>(vectors * kernel_.lanes, 1));
  std::fill(array.get(), array.get() + vectors * kernel_.lanes, T(0));
  return array;
}

template <class T>
void NewtonBars<T>::begin(Lane& lane, int most) const {
  lane.steps = 0;
  lane.most = most;
  lane.worst = 0;
  lane.start = nullptr;
  lane.waits = lane.fresh = lane.settled = false;
  lane.state = State::given_up;
}

template <class T>
void NewtonBars<T>::load(int index, std::span<const Vec3> positions, std::vector<Vec3>& start,
                         int most) {
  Lane& lane = lanes_[std::size_t(index)];
  begin(lane, most);
  start.resize(positions.size());
  const Extent extent = copy_and_survey(positions, start.data());
  lane.start = start.data();
  if constexpr (Slack<T>::single) {
    if (!lane.frame.centre(extent)) return;
    lane.stands = lane.frame.stands_for_doubles(extent);
  } else {
    if (!extent.finite) return;
  }
  lane.state = State::busy;
  lane.waits = lane.fresh = true;
}

template <class T>
void NewtonBars<T>::load_in_place(std::span<Vec3> positions, int most) {
  Lane& lane = lanes_.front();
  begin(lane, most);
  lane.fresh = lane.frame.centre(positions);
  if (lane.fresh) lane.state = State::busy;
  if constexpr (!Slack<T>::single) task_.x = positions.data()->data();
}

/// Lanes that were loaded one after the other go into their places together.
template <class T>
void NewtonBars<T>::put_waiting() {
  if constexpr (Slack<T>::single) {
    std::vector<LaneSource>& sources = sources_;
    sources.assign(lanes_.size(), {});
    for (std::size_t k = 0; k < lanes_.size(); ++k)
      if (lanes_[k].waits) sources[k] = {lanes_[k].start, lanes_[k].frame.reference()};
    put_lanes(sources, plan_->joint_count, x_.get());
  } else {
    for (std::size_t k = 0; k < lanes_.size(); ++k)
      for (std::size_t j = 0; lanes_[k].waits && j < plan_->joint_count; ++j)
        lanes_[k].frame.put(lanes_[k].start[j], points(int(k)), int(j));
  }
  for (Lane& lane : lanes_) lane.waits = false;
}

template <class T>
void NewtonBars<T>::iterate() {
  bool any = false, fresh = false, waits = false;
  for (const Lane& lane : lanes_) {
    any |= lane.state == State::busy;
    fresh |= lane.fresh;
    waits |= lane.waits;
  }
  if (!any) return;
  if (std::any_of(lanes_.begin(), lanes_.end(), is_unsettled)) settle();
  if (waits) put_waiting();
  if (fresh) look();
  any = false;
  for (std::size_t k = 0; k < lanes_.size(); ++k) {
    const bool busy = lanes_[k].state == State::busy;
    busy_[k] = T(busy);
    lanes_[k].steps += busy;
    any |= busy;
  }
  if (!any) return;
  kernel_.step(task_);
  look();
}

/// Ends the lanes whose bars are within tolerance, and those that get nowhere.
template <class T>
void NewtonBars<T>::look() {
  kernel_.look(task_);
  for (std::size_t k = 0; k < lanes_.size(); ++k) {
    Lane& lane = lanes_[k];
    if (lane.state != State::busy) continue;
    if (!lane.fresh && lane.steps == 0) continue;
    const double worst = double(worst_[k]);
    const bool first = lane.fresh;
    lane.fresh = false;
    if (!std::isfinite(double(sum_[k]))) {
      lane.state = State::given_up;
    } else if (worst <= 1) {
      lane.state = State::ended;
      if (!Slack<T>::single) lane.residual = {double(relative_[k]), double(largest_[k])};
    } else if (lane.steps >= lane.most || (!first && worst > lane.worst)) {
      lane.state = State::given_up;
    }
    lane.worst = worst;
  }
}

/// Takes and measures the lanes that have ended, together. What floats find to be less violated,
/// by more than they round, need not be measured.
template <class T>
void NewtonBars<T>::settle() {
  if constexpr (Slack<T>::single) {
    constexpr double rounding = 2 * Slack<T>::rounding;
    constexpr T never = std::numeric_limits<T>::infinity();
    bool any = false;
    for (std::size_t k = 0; k < lanes_.size(); ++k) {
      Lane& lane = lanes_[k];
      const bool wanted = is_unsettled(lane);
      any |= wanted;
      wanted_[k] = T(wanted);
      relative_from_[k] = largest_from_[k] = never;
      if (!wanted || lane.state != State::ended) continue;
      // distances over lengths are no less, products round
      const double nearest = (1 - double(relative_[k]) - rounding) * (1 - rounding);
      relative_from_[k] = T((double(relative_[k]) - rounding) * nearest);
      largest_from_[k] = T((double(largest_[k]) - rounding * longest_) * nearest);
    }
    if (!any) return;
    take_lanes(x_.get(), plan_->joint_count, {wanted_.get(), lanes_.size()}, rows_.get());
    kernel_.measure(task_);
    for (std::size_t k = 0; k < lanes_.size(); ++k) {
      if (wanted_[k] == 0) continue;
      lanes_[k].settled = true;
      Residual& residual = lanes_[k].residual;
      residual = {exact_relative_[k], exact_largest_[k]};
      residual.within =
          (tolerance_.absolute() ? residual.nanometers : residual.relative) <= tolerance_.value();
    }
  }
}

template <class T>
bool NewtonBars<T>::unload(int index, std::span<Vec3> positions) {
  Lane& lane = lanes_[std::size_t(index)];
  if constexpr (Slack<T>::single) {
    if (!lane.settled) settle();
    const T* const row = rows_.get() + std::size_t(index) * 3 * plan_->joint_count;
    const std::size_t kept = place_row(row, lane.frame.reference(), lane.start, positions);
    free(index);
    return kept == 0 && lane.stands;
  }
  // in place they are there already
  if (task_.x == x_.get()) lane.frame.take(points(index), positions);
  free(index);
  return true;
}

template class NewtonBars<float>;
template class NewtonBars<double>;

}  // namespace ragdoll
