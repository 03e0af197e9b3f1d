#include "ordered_passes.h"

#include <cmath>  // abs, sqrt, isfinite

#include "ragdoll/order.h"   // check_roots
#include "ragdoll/random.h"  // Random

namespace ragdoll {

template <class T>
OrderedPasses<T>::OrderedPasses(const Framework& framework, const ResolverSettings& settings)
    : framework_(framework),
      settings_(settings),
      joint_count_(std::size_t(framework.joint_count())),
      sweep_order_(framework, settings),
      constraints_(framework, settings),
      looked_up_at_(framework.contact_rule().empty() ? 0 : 3 * joint_count_),
      near_contacts_(framework, constraints_.slack, near_contact_list(framework),
                     {looked_up_at_.data(), joint_count_}),
      work_list_(framework.graph()) {}

template <class T>
OrderedOutcome OrderedPasses<T>::run(T* x, const Breakage& breakage) {
  x_ = x;
  box_ = breakage.box;
  tally_ = {};
  near_contacts_.begin(breakage.box);
  few_ = only_few_moved(breakage);
  resolved_ = false;
  placed_residual_.reset();
  if (!all_finite(breakage)) return {StopReason::not_finite};
  Random random(settings_.seed, RandomStream::order, breakage.step);
  prepare_order(breakage, random);
  if (uses_work_list()) mark_moved(breakage);
  const OrderedOutcome outcome = places_ ? loop_in_places(random) : loop(random);
  resolved_ = is_resolved(outcome.reason);
  if (uses_work_list()) remember();
  return outcome;
}

template <class T>
OrderedOutcome OrderedPasses<T>::loop(Random& random) {
  OrderedOutcome outcome;
  const auto end = [&](StopReason reason) {
    outcome.reason = reason;
    return outcome;
  };
  // a pass that corrects nothing tells that the pass before it was the last
  while (true) {
    const bool last = outcome.iterations == settings_.max_iterations;
    if (outcome.iterations > 0 && sweep_order_.changes()) {
      if (within_tolerance()) return end(StopReason::within_tolerance);
      Order order;
      if (!last && sweep_order_.change(tally_.last_problem, worst_bar(), random, order))
        set_order(order);
    }
    if (last)
      return end(within_tolerance() ? StopReason::within_tolerance : StopReason::max_iterations);
    tally_ = {};
    sweep_constraints();
    if (tally_.corrections == 0) {
      if (!tally_.finite) return end(StopReason::not_finite);
      if (tally_.held == 0 && (settings_.custom_order.empty() || within_tolerance()))
        return end(outcome.iterations == 0 ? StopReason::nothing_broken
                                           : StopReason::within_tolerance);
      // what is left lies between fixed joints, or the custom order leaves it out: further passes
      // would do nothing
      outcome.bar_visits += (settings_.max_iterations - outcome.iterations) * bar_visits_;
      outcome.iterations = settings_.max_iterations;
      return end(StopReason::max_iterations);
    }
    ++outcome.iterations;
    outcome.bar_visits += bar_visits_;
    if (!tally_.finite) return end(StopReason::not_finite);
  }
}

/// The same on a copy of the positions. Of its last pass the residual is told from the copy, too.
template <class T>
OrderedOutcome OrderedPasses<T>::loop_in_places(Random& random) {
  T* const x = x_;
  places_->gather(x, placed_);
  x_ = placed_.data();
  const OrderedOutcome outcome = loop(random);
  if (is_resolved(outcome.reason) && !Slack<T>::single) placed_residual_ = residual_in_places();
  x_ = x;
  places_->scatter(placed_, x);
  return outcome;
}

template <class T>
Residual OrderedPasses<T>::residual_in_places() const {
  const auto at_place = [this](int place) { return points().at(place); };
  const auto at = [this](int joint) { return points().at(places_->of(joint)); };
  return residual_of(framework_, placed_bars_, at_place, at, box_, settings_.tolerance,
                     std::span<const NearPair>());
}

// === Order

template <class T>
void OrderedPasses<T>::prepare_order(const Breakage& breakage, Random& random) {
  if (uses_work_list() && sweep_order_.by_visit()) {
    if (!sweep_order_.start(breakage.roots)) return;
    constraints_.clear_order();
    work_list_.start_over(framework_.bars().size(), sweep_order_.and_back());
    return;
  }
  Order order;
  if (!sweep_order_.prepare(breakage.roots, random, order)) return;
  set_order(order);
  place_joints(order);
}

/// Orders that change from pass to pass cost more than what places could save. The contact rule
/// looks for its pairs by the joints' own numbers; a work list is for breaks of few joints.
template <class T>
void OrderedPasses<T>::place_joints(const Order& order) {
  if (places_) {
    // of the order before
    places_.reset();
    constraints_.set_others();
  }
  if (sweep_order_.changes() || uses_work_list() || !settings_.custom_order.empty() ||
      !near_contacts_.empty() || !JointPlaces::pay(order, joint_count_, 3 * sizeof(T)))
    return;
  places_.emplace(order, joint_count_);
  const auto place = [this](int joint) { return places_->of(joint); };
  constraints_.renumber(place);
  placed_bars_.clear();
  placed_bars_.reserve(order.size());
  for (const Visit& visit : order) {
    Bar bar = framework_.bars()[std::size_t(visit.bar)];
    bar.p = place(bar.p);
    bar.q = place(bar.q);
    placed_bars_.push_back(bar);
  }
}

template <class T>
void OrderedPasses<T>::set_order(const Order& order) {
  constraints_.set_order(order, sweep_order_);
  if (!uses_work_list()) return;
  work_list_.start_over(order.size());
  for (const Visit& visit : order) work_list_.append(visit.bar);
}

// === Work list

template <class T>
bool OrderedPasses<T>::uses_work_list() const {
  const bool always =
      settings_.order == OrderKind::bfs_active || settings_.order == OrderKind::bfs_worst;
  return (always && settings_.custom_order.empty()) ||
         (settings_.work_list && !sweep_order_.changes());
}

/// Floats are rounded anew for each break, so that all of them move.
template <class T>
bool OrderedPasses<T>::only_few_moved(const Breakage& breakage) const {
  return breakage.only_roots_moved && resolved_ && uses_work_list() && !sweep_order_.changes() &&
         bars_only() && !Slack<T>::single;
}

template <class T>
void OrderedPasses<T>::mark_moved(const Breakage& breakage) {
  if (!few_) {
    moved_.clear();
    work_list_.move_changed(x_);
    return;
  }
  const auto resolved = [this](int joint) {
    const T* const point = work_list_.remembered().data() + 3 * std::ptrdiff_t(joint);
    return Vec3(double(point[0]), double(point[1]), double(point[2]));
  };
  if (!known_residual_) known_residual_.emplace(framework_, resolved);
  is_moved_.resize(joint_count_, 0);
  moved_.clear();
  for (const int root : breakage.roots) move(root);
}

template <class T>
void OrderedPasses<T>::move(int joint) {
  work_list_.move(joint);
  if (!few_ || is_moved_[std::size_t(joint)]) return;
  is_moved_[std::size_t(joint)] = 1;
  moved_.push_back(joint);
}

template <class T>
void OrderedPasses<T>::remember() {
  if (!few_ || !resolved_) {
    work_list_.remember(x_);
    known_residual_.reset();
  } else {
    const auto at = [this](int joint) { return points().at(joint); };
    for (const int joint : moved_) {
      work_list_.remember(x_, joint);
      for (const Graph::Link& link : framework_.graph().links(joint))
        known_residual_->update(link.bar, at);
    }
    known_residual_->settle();
  }
  for (const int joint : moved_) is_moved_[std::size_t(joint)] = 0;
}

/// The first visit from this place of the order on whose bar could be violated.
template <class T>
std::size_t OrderedPasses<T>::next_moved(std::size_t place) {
  while (true) {
    const std::size_t next = work_list_.next(place);
    // what is left to be told lies before all that is on the way back
    const bool found = next != RankSet::none && !work_list_.is_back(next);
    if (found || work_list_.is_back(place) || !work_list_.expects_places() ||
        !sweep_order_.by_visit())
      return next;
    Visit visit;
    if (!sweep_order_.next(visit)) return next;
    constraints_.append(visit, sweep_order_.even(visit));
    work_list_.append(visit.bar);
  }
}

// === Sweep

template <class T>
bool OrderedPasses<T>::bars_only() const {
  return constraints_.tethers.empty() && constraints_.contacts.empty() &&
         constraints_.volumes.empty() && near_contacts_.empty();
}

template <class T>
void OrderedPasses<T>::sweep_constraints() {
  if (uses_work_list()) {
    sweep_work_list();
    if (!bars_only()) work_list_.remember(x_);
  } else {
    sweep_bars();
    bar_visits_ = std::int64_t(constraints_.bars.size());
  }
  sweep_pairs<Side::upper>(constraints_.tethers, x_, tally_);
  sweep_pairs<Side::lower>(constraints_.contacts, x_, tally_);
  if (!near_contacts_.empty()) near_contacts_.sweep(points(), tally_);
  sweep_volumes(constraints_.volumes, x_, tally_);
  // what these move breaks bars
  if (uses_work_list() && !bars_only()) work_list_.move_changed(x_);
}

template <class T>
void OrderedPasses<T>::sweep_bars() {
  T* const x = x_;
  const BarVisit<T>* const visits = constraints_.bars.data();
  const BarCorrection<T>* const corrections = constraints_.corrections.data();
  const std::size_t count = constraints_.bars.size();
  for (std::size_t k = 0; k < count; ++k) {
    const BarVisit<T>& visit = visits[k];
    T* const p = x + 3 * std::ptrdiff_t(visit.near);
    T* const q = x + 3 * std::ptrdiff_t(visit.far);
    const Difference<T> d(p, q);
    const T distance2 = d.square();
    if (distance2 >= visit.lower2 && distance2 <= visit.upper2) continue;
    const BarCorrection<T>& bar = corrections[k];
    const T distance = std::sqrt(distance2);
    const T error = bar.length - distance;
    if (std::abs(error) <= bar.slack) continue;
    if (bar.near_share == 0 && bar.far_share == 0) {
      ++tally_.held;
      continue;
    }
    ++tally_.corrections;
    if (bar.problem) tally_.last_problem = bar.bar;
    if (!std::isfinite(distance)) tally_.finite = false;
    move_apart(p, q, d, distance, error, bar.near_share, bar.far_share);
  }
}

/// What sweep_bars does, without the bars that are where they were last found within tolerance.
template <class T>
void OrderedPasses<T>::sweep_work_list() {
  bar_visits_ = 0;
  for (std::size_t k = next_moved(0); k != RankSet::none; k = next_moved(k + 1)) {
    const std::size_t at = work_list_.appended_at(k);
    const BarVisit<T> visit = constraints_.bars[at];
    const BarCorrection<T> bar = constraints_.corrections[at];
    ++bar_visits_;
    T* const p = x_ + 3 * std::ptrdiff_t(visit.near);
    T* const q = x_ + 3 * std::ptrdiff_t(visit.far);
    const Difference<T> d(p, q);
    const T distance = std::sqrt(d.square());
    const T error = bar.length - distance;
    if (std::abs(error) <= bar.slack) {
      work_list_.settle(bar.bar);
    } else if (bar.near_share == 0 && bar.far_share == 0) {
      ++tally_.held;
    } else {
      ++tally_.corrections;
      if (!std::isfinite(distance)) tally_.finite = false;
      move_apart(p, q, d, distance, error, bar.near_share, bar.far_share);
      if (bar.near_share != 0) move(visit.near);
      if (bar.far_share != 0) move(visit.far);
      // the shares add to 1, so that it is satisfied now; but for rounding
      if (std::abs(bar.length - std::sqrt(Difference<T>(p, q).square())) <= bar.slack)
        work_list_.settle(bar.bar);
    }
  }
}

template <class T>
bool OrderedPasses<T>::all_finite(const Breakage& breakage) const {
  if (few_) {
    check_roots(framework_.graph(), breakage.roots);
    for (const int root : breakage.roots)
      if (!points().at(root).allFinite()) return false;
    return true;
  }
  T sum = 0;
  for (std::size_t k = 0; k < 3 * joint_count_; ++k) sum += x_[k] * 0;
  return sum == 0;
}

/// The bar that is violated most (the first of them on ties), or -1.
template <class T>
int OrderedPasses<T>::worst_bar() const {
  if (settings_.order != OrderKind::bfs_worst) return -1;
  int worst = -1;
  double largest = settings_.tolerance.value();
  const std::vector<Bar>& bars = framework_.bars();
  for (std::size_t k = 0; k < bars.size(); ++k) {
    const Vec3 d = points().at(bars[k].q) - points().at(bars[k].p);
    const double error = std::abs(d.norm() - bars[k].length);
    const double unit = settings_.tolerance.absolute() ? 1 : bars[k].length;
    if (error <= largest * unit) continue;
    largest = error / unit;
    worst = int(k);
  }
  return worst;
}

template class OrderedPasses<float>;
template class OrderedPasses<double>;

}  // namespace ragdoll
