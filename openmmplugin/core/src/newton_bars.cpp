#include "newton_bars.h"

#include <algorithm>  // fill, max, min
#include <cmath>      // isfinite

#include "sweep_arithmetic.h"  // Slack

namespace ragdoll {

template <class T>
NewtonBars<T>::NewtonBars(std::shared_ptr<const NewtonBarsPlan> plan, const Framework& framework,
                          const Tolerance& tolerance, bool wide)
    : plan_(std::move(plan)),
      kernel_(newton_bars_kernel<T>(wide)),
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
  const std::size_t bars = bars_.size();
  x_ = zeros(3 * plan_->joint_count);
  d_ = zeros(3 * bars);
  value_ = zeros(bars + entries_.size());
  inverse_ = zeros(bars);
  z_ = zeros(bars);
  busy_ = zeros(1);
  worst_ = zeros(1);
  relative_ = zeros(1);
  largest_ = zeros(1);
  sum_ = zeros(1);
  task_ = {bars,
           entries_.size(),
           bars_.data(),
           entries_.data(),
           plan_->begin.data(),
           plan_->targets.data(),
           T(std::max(mean * hair, 1e-30)),
           x_.get(),
           d_.get(),
           value_.get(),
           inverse_.get(),
           z_.get(),
           busy_.get(),
           worst_.get(),
           relative_.get(),
           largest_.get(),
           sum_.get()};
}

template <class T>
typename NewtonBars<T>::Array NewtonBars<T>::zeros(std::size_t vectors) const {
  Array array = hwy::AllocateAligned<T>(std::max<std::size_t>(vectors * kernel_.lanes, 1));
  std::fill(array.get(), array.get() + vectors * kernel_.lanes, T(0));
  return array;
}

template <class T>
void NewtonBars<T>::load(int index, std::span<const Vec3> positions, int most) {
  Lane& lane = lanes_[std::size_t(index)];
  lane.steps = 0;
  lane.most = most;
  lane.worst = 0;
  lane.fresh = false;
  lane.state = State::given_up;
  if (!lane.frame.centre(positions)) return;
  const StridedPoints<T> to = points(index);
  for (std::size_t j = 0; j < positions.size(); ++j) lane.frame.put(positions[j], to, int(j));
  lane.state = State::busy;
  lane.fresh = true;
}

template <class T>
void NewtonBars<T>::load_in_place(std::span<Vec3> positions, int most) {
  Lane& lane = lanes_.front();
  lane.steps = 0;
  lane.most = most;
  lane.worst = 0;
  lane.fresh = lane.frame.centre(positions);
  lane.state = lane.fresh ? State::busy : State::given_up;
  if constexpr (!Slack<T>::single) task_.x = positions.data()->data();
}

template <class T>
void NewtonBars<T>::iterate() {
  bool any = false, fresh = false;
  for (const Lane& lane : lanes_) {
    any |= lane.state == State::busy;
    fresh |= lane.fresh;
  }
  if (!any) return;
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
      lane.residual = {double(relative_[k]), double(largest_[k])};
    } else if (lane.steps >= lane.most || (!first && worst > lane.worst)) {
      lane.state = State::given_up;
    }
    lane.worst = worst;
  }
}

template <class T>
void NewtonBars<T>::unload(int index, std::span<Vec3> positions) {
  const Lane& lane = lanes_[std::size_t(index)];
  // in place they are there already
  if (task_.x == x_.get() && (Slack<T>::single || lane.steps > 0))
    lane.frame.take(points(index), positions);
  free(index);
}

template class NewtonBars<float>;
template class NewtonBars<double>;

}  // namespace ragdoll
