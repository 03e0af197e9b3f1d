// The thesis' sweep: every bar in its order, each corrected along itself by its weighting, again
// and again until all are within tolerance. Tethers, contacts and volumes follow the bars in each
// pass. bfs_active and bfs_worst are ours: they leave out the bars that nothing moved since they
// were last found within tolerance.

#include "resolver_ordered.h"

#include <algorithm>  // max, upper_bound
#include <cmath>      // abs, sqrt, isfinite
#include <utility>    // move

#include "constraints.h"           // VolumeGradient, volume_violation
#include "moved_bars.h"            // MovedBars
#include "ragdoll/classify.h"      // classify
#include "ragdoll/contact_list.h"  // ContactList
#include "ragdoll/random.h"        // Random

namespace ragdoll {
namespace {

/// Contact pairs are searched for up to their bound plus the skin, and looked at in each pass up to
/// their bound plus the reach. Both only decide how often the pairs are looked up, never the
/// result.
constexpr double contact_skin = 0.16;   // nm
constexpr double contact_reach = 0.02;  // nm

/// How often a pass looks pairs up anew; a break that resolves needs none or a few.
constexpr int most_renewals = 64;

/// A bar as the sweep visits it.
struct SweepBar {
  int near, far;
  double length;
  double lower2, upper2;         ///< squared distances that are surely within tolerance
  double near_share, far_share;  ///< of the error; 0 and 0: both ends are fixed
  bool problem;
  int bar;
};

class OrderedResolver final : public Resolver {
 public:
  OrderedResolver(std::shared_ptr<const Framework> framework, const ResolverSettings& settings)
      : framework_(std::move(framework)),
        settings_(settings),
        contact_list_(framework_->contact_rule(), contact_skin),
        moved_bars_(framework_->graph()) {}

  std::string solver() const override { return "ordered"; }

  ResolveReport resolve(std::span<Vec3> positions, const Breakage& breakage) override {
    x_ = positions;
    box_ = breakage.box;
    if (scattered_) looked_up_at_.clear();  // whatever came before, start from the positions alone
    ResolveReport report;
    if (!all_finite()) return finish(report, StopReason::not_finite);

    Random random(settings_.seed, RandomStream::order, breakage.step);
    prepare_order(breakage, random);
    if (only_moved_bars()) moved_bars_.move_changed(x_);
    // a pass that corrects nothing tells that the pass before it was the last
    while (true) {
      if (report.iterations > 0 && order_changes()) {
        if (within_tolerance()) return finish(report, StopReason::within_tolerance);
        if (report.iterations < settings_.max_iterations) next_order(breakage, random);
      }
      if (report.iterations == settings_.max_iterations) {
        const bool done = within_tolerance();
        return finish(report, done ? StopReason::within_tolerance : StopReason::max_iterations);
      }
      corrections_ = 0;
      held_ = 0;
      last_problem_ = -1;
      sweep_constraints();
      if (corrections_ == 0) {
        if (held_ == 0 && (settings_.custom_order.empty() || within_tolerance()))
          return finish(report, report.iterations == 0 ? StopReason::nothing_broken
                                                       : StopReason::within_tolerance);
        // what is left lies between fixed joints, or the custom order leaves it out: further passes
        // would do nothing
        report.bar_visits += (settings_.max_iterations - report.iterations) * visits_;
        report.iterations = settings_.max_iterations;
        return finish(report, StopReason::max_iterations);
      }
      ++report.iterations;
      report.bar_visits += visits_;
      if (!finite_) return finish(report, StopReason::not_finite);
    }
  }

 private:
  // === Order

  bool order_changes() const {
    return settings_.custom_order.empty() &&
           (settings_.order == OrderKind::random || settings_.order == OrderKind::bfs_adapt ||
            settings_.order == OrderKind::bfs_random || settings_.order == OrderKind::bfs_worst);
  }

  bool only_moved_bars() const {
    return settings_.custom_order.empty() &&
           (settings_.order == OrderKind::bfs_active || settings_.order == OrderKind::bfs_worst);
  }

  /// The order of the first iteration; kept while the roots stay the same.
  void prepare_order(const Breakage& breakage, Random& random) {
    if (!settings_.custom_order.empty()) {
      if (sweep_.empty()) set_order(settings_.custom_order);
      return;
    }
    const std::vector<int> roots =
        breakage.roots.empty() ? middle_joints()
                               : std::vector<int>(breakage.roots.begin(), breakage.roots.end());
    if (order_ready_ && roots == roots_ && !order_changes()) return;
    roots_ = roots;
    set_order(order_of(framework_->graph(), settings_.order, roots_, random));
    order_ready_ = true;
  }

  /// Orders that change from one iteration to the next.
  void next_order(const Breakage&, Random& random) {
    const Graph& graph = framework_->graph();
    if (settings_.order == OrderKind::random) {
      set_order(shuffled_order(graph, random));
    } else if (settings_.order == OrderKind::bfs_random) {
      std::vector<int> roots = {int(random.below(std::uint64_t(graph.joint_count())))};
      roots.insert(roots.end(), roots_.begin(), roots_.end());
      set_order(order_of(graph, OrderKind::bfs_cycle, roots, random));
    } else if (settings_.order == OrderKind::bfs_worst) {
      const int worst = worst_bar();
      if (worst >= 0) set_order(adapted_order(graph, worst, roots_));
    } else if (last_problem_ >= 0) {
      set_order(adapted_order(graph, last_problem_, roots_));
    }
  }

  /// The bar that is violated most (the first of them on ties), or -1.
  int worst_bar() const {
    int worst = -1;
    double largest = settings_.tolerance.value();
    const std::vector<Bar>& bars = framework_->bars();
    for (std::size_t k = 0; k < bars.size(); ++k) {
      const double error = std::abs((at(bars[k].q) - at(bars[k].p)).norm() - bars[k].length);
      if (error <= largest * bars[k].length) continue;
      largest = error / bars[k].length;
      worst = int(k);
    }
    return worst;
  }

  /// bfs_worst shares errors evenly where cycles are dense, 3 bars for 2 joints or more: there any
  /// other weighting sends them round and round.
  bool in_dense_block(int bar) {
    if (settings_.order != OrderKind::bfs_worst || !settings_.custom_order.empty()) return false;
    if (dense_.empty()) {
      dense_.assign(framework_->bars().size(), 0);
      for (const Block& block : classify(framework_->graph()).blocks)
        if (2 * block.bars.size() >= 3 * block.joints.size())
          for (const int k : block.bars) dense_[std::size_t(k)] = 1;
    }
    return dense_[std::size_t(bar)] != 0;
  }

  const std::vector<int>& middle_joints() {
    if (middle_joints_.empty()) {
      MiddleJoint middle(framework_->graph());
      for (const int lowest : framework_->components().lowest_joint)
        middle_joints_.push_back(middle.of(lowest));
    }
    return middle_joints_;
  }

  void set_order(const Order& order) {
    const double tol = settings_.tolerance.value();
    // closer to the bounds than rounding reaches, the exact test decides
    constexpr double inside = 1e-12;
    sweep_.resize(order.size());
    for (std::size_t k = 0; k < order.size(); ++k) {
      const Visit& visit = order[k];
      const double length = framework_->bars()[std::size_t(visit.bar)].length;
      const double lower = std::max(0.0, length * (1 - tol)) * (1 + inside);
      const double upper = length * (1 + tol) * (1 - inside);
      const bool even = visit.problem || in_dense_block(visit.bar);
      auto [near, far] = shares(visit.near, visit.far, even ? Weighting{} : settings_.weighting);
      sweep_[k] = {visit.near, visit.far, length, lower * lower, upper * upper,
                   near,       far,       even,   visit.bar};
    }
  }

  /// A fixed end takes share 0, the other 1; both fixed: nothing moves.
  std::pair<double, double> shares(int near, int far, const Weighting& weighting) const {
    const bool near_fixed = framework_->fixed()[std::size_t(near)];
    const bool far_fixed = framework_->fixed()[std::size_t(far)];
    if (near_fixed && far_fixed) return {0, 0};
    if (near_fixed) return {0, 1};
    if (far_fixed) return {1, 0};
    return {weighting.near, weighting.far};
  }

  // === Sweep

  void sweep_constraints() {
    if (only_moved_bars()) {
      sweep_moved_bars();
      if (!bars_only()) moved_bars_.remember(x_);
    } else {
      sweep_bars();
      visits_ = std::int64_t(sweep_.size());
    }
    sweep_pairs();
    sweep_volumes();
    // what these move breaks bars
    if (only_moved_bars() && !bars_only()) moved_bars_.move_changed(x_);
  }

  bool bars_only() const {
    return framework_->tethers().empty() && framework_->contacts().empty() &&
           framework_->contact_rule().empty() && framework_->volumes().empty();
  }

  /// What sweep_bars does, without the bars that are where they were last found within tolerance.
  void sweep_moved_bars() {
    const double tol = settings_.tolerance.value();
    visits_ = 0;
    for (const SweepBar& bar : sweep_) {
      if (!moved_bars_.has(bar.bar)) continue;
      ++visits_;
      Vec3& p = x_[std::size_t(bar.near)];
      Vec3& q = x_[std::size_t(bar.far)];
      const Vec3 d = q - p;
      const double distance = d.norm();
      const double error = bar.length - distance;
      if (std::abs(error) <= tol * bar.length) {
        moved_bars_.settle(bar.bar);
      } else if (bar.near_share == 0 && bar.far_share == 0) {
        ++held_;
      } else {
        ++corrections_;
        move_apart(p, q, d, distance, error, bar.near_share, bar.far_share);
        if (bar.near_share != 0) moved_bars_.move(bar.near);
        if (bar.far_share != 0) moved_bars_.move(bar.far);
        // the shares add to 1, so that it is satisfied now; but for rounding
        if (std::abs(bar.length - (q - p).norm()) <= tol * bar.length) moved_bars_.settle(bar.bar);
      }
    }
  }

  void sweep_bars() {
    const double tol = settings_.tolerance.value();
    Vec3* const x = x_.data();
    for (const SweepBar& bar : sweep_) {
      Vec3& p = x[bar.near];
      Vec3& q = x[bar.far];
      const Vec3 d = q - p;
      const double distance2 = d.squaredNorm();
      if (distance2 >= bar.lower2 && distance2 <= bar.upper2) continue;
      const double distance = std::sqrt(distance2);
      const double error = bar.length - distance;
      if (std::abs(error) <= tol * bar.length) continue;
      if (bar.near_share == 0 && bar.far_share == 0) {
        ++held_;
        continue;
      }
      ++corrections_;
      if (bar.problem) last_problem_ = bar.bar;
      move_apart(p, q, d, distance, error, bar.near_share, bar.far_share);
    }
  }

  /// Adds `error` to the distance from p to q, shared between them. Two joints at one place part in
  /// +x.
  void move_apart(Vec3& p, Vec3& q, const Vec3& d, double distance, double error, double p_share,
                  double q_share) {
    if (!std::isfinite(distance)) finite_ = false;
    const Vec3 unit = distance > 0 ? Vec3(d / distance) : Vec3(1, 0, 0);
    p -= (p_share * error) * unit;
    q += (q_share * error) * unit;
  }

  /// Tethers and contacts, .5/.5, corrected only when violated.
  void sweep_pairs() {
    for (const Tether& tether : framework_->tethers())
      bound_pair(tether.p, tether.q, tether.length, 1, nullptr);
    for (const Contact& contact : framework_->contacts())
      bound_pair(contact.p, contact.q, contact.length, -1, nullptr);
    if (!framework_->contact_rule().empty()) sweep_contact_rule();
  }

  /// One tether (side 1) or contact (side -1). @return true if the joints moved
  bool bound_pair(int p, int q, double length, int side, const Box* box) {
    Vec3& a = x_[std::size_t(p)];
    Vec3& b = x_[std::size_t(q)];
    Vec3 d = b - a;
    if (box) d = box->minimum_image(d);
    const double distance = d.norm();
    const double excess = side * (distance - length);
    if (excess <= settings_.tolerance.value() * length) return false;
    const auto [p_share, q_share] = shares(p, q, Weighting{});
    if (p_share == 0 && q_share == 0) {
      ++held_;
      return false;
    }
    ++corrections_;
    move_apart(a, b, d, distance, length - distance, p_share, q_share);
    return true;
  }

  /// Pairs of the contact rule. Only those that could be violated are looked at; when joints have
  /// moved so far that others could be, the pairs are looked up anew and the pass goes on behind
  /// the pair it had come to. So the result is that of looking at every pair in each pass.
  void sweep_contact_rule() {
    if (!reach_holds()) {
      if (!finite_ || !all_finite()) {
        finite_ = false;
        return;
      }
      look_up_pairs();
    }
    const double narrow = 1 - settings_.tolerance.value();
    int renewals = 0;
    scattered_ = false;
    for (std::size_t k = 0; k < near_.size(); ++k) {
      const NearPair pair = near_[k];
      Vec3 d = x_[std::size_t(pair.q)] - x_[std::size_t(pair.p)];
      if (box_) d = box_->minimum_image(d);
      const double lower = pair.bound * narrow;
      if (d.squaredNorm() > lower * lower * (1 + 1e-12)) continue;
      if (!bound_pair(pair.p, pair.q, pair.bound, -1, box_)) continue;
      if (moved_within_reach(pair.p) && moved_within_reach(pair.q)) continue;
      if (!finite_) return;
      // joints that fly about leave the rest to the next pass
      if (renewals++ == most_renewals) scattered_ = true;
      if (scattered_) continue;
      look_up_pairs();
      const auto after = std::upper_bound(
          near_.begin(), near_.end(), pair,
          [](const NearPair& a, const NearPair& b) { return a.p != b.p ? a.p < b.p : a.q < b.q; });
      k = std::size_t(after - near_.begin()) - 1;
    }
  }

  bool moved_within_reach(int joint) const {
    constexpr double room = contact_reach / 2;
    const std::size_t j = std::size_t(joint);
    return (x_[j] - looked_up_at_[j]).squaredNorm() < room * room;
  }

  bool reach_holds() const {
    if (looked_up_at_.size() != x_.size() || had_box_ != (box_ != nullptr)) return false;
    if (box_ && (box_->a != last_box_.a || box_->b != last_box_.b || box_->c != last_box_.c))
      return false;
    constexpr double room = contact_reach / 2;
    double largest2 = 0;
    for (std::size_t j = 0; j < x_.size(); ++j)
      largest2 = std::max(largest2, (x_[j] - looked_up_at_[j]).squaredNorm());
    return largest2 < room * room;
  }

  /// The pairs within reach of their bounds, from the list that the skin keeps.
  void look_up_pairs() {
    contact_list_.update(x_, box_, contact_reach);
    near_.clear();
    for (const NearPair& pair : contact_list_.pairs()) {
      Vec3 d = x_[std::size_t(pair.q)] - x_[std::size_t(pair.p)];
      if (box_) d = box_->minimum_image(d);
      const double limit = pair.bound + contact_reach;
      if (d.squaredNorm() < limit * limit) near_.push_back(pair);
    }
    looked_up_at_.assign(x_.begin(), x_.end());
    had_box_ = box_ != nullptr;
    if (box_) last_box_ = *box_;
  }

  /// Each violated volume to its nearest bound along its gradient: the smallest move that does it.
  void sweep_volumes() {
    for (const Volume& v : framework_->volumes()) {
      Vec3& a = x_[std::size_t(v.a)];
      Vec3& b = x_[std::size_t(v.b)];
      Vec3& c = x_[std::size_t(v.c)];
      Vec3& d = x_[std::size_t(v.d)];
      const double volume = signed_volume(a, b, c, d);
      if (volume_violation(v, volume) <= settings_.tolerance.value()) continue;
      VolumeGradient gradient(a, b, c, d);
      const auto& fixed = framework_->fixed();
      if (fixed[std::size_t(v.a)]) gradient.a.setZero();
      if (fixed[std::size_t(v.b)]) gradient.b.setZero();
      if (fixed[std::size_t(v.c)]) gradient.c.setZero();
      if (fixed[std::size_t(v.d)]) gradient.d.setZero();
      const double square = gradient.a.squaredNorm() + gradient.b.squaredNorm() +
                            gradient.c.squaredNorm() + gradient.d.squaredNorm();
      // no direction changes the volume: all fixed, or all joints on a line
      if (!(square > 0)) {
        ++held_;
        continue;
      }
      const double step = ((volume < v.lower ? v.lower : v.upper) - volume) / square;
      if (!std::isfinite(step)) finite_ = false;
      a += step * gradient.a;
      b += step * gradient.b;
      c += step * gradient.c;
      d += step * gradient.d;
      ++corrections_;
    }
  }

  // === Result

  bool all_finite() const {
    double sum = 0;
    for (const Vec3& position : x_) sum += position.sum() * 0;
    return sum == 0;
  }

  bool within_tolerance() { return residual() <= settings_.tolerance.value(); }

  /// Largest relative violation, from the pairs that are looked up anyway.
  double residual() {
    const auto distance = [this](const auto& pair) {
      return (x_[std::size_t(pair.q)] - x_[std::size_t(pair.p)]).norm();
    };
    double largest = 0;
    for (const Bar& bar : framework_->bars())
      largest = std::max(largest, std::abs(distance(bar) - bar.length) / bar.length);
    for (const Tether& tether : framework_->tethers())
      largest = std::max(largest, distance(tether) / tether.length - 1);
    for (const Contact& contact : framework_->contacts())
      largest = std::max(largest, 1 - distance(contact) / contact.length);
    for (const Volume& v : framework_->volumes())
      largest =
          std::max(largest, volume_violation(v, signed_volume(at(v.a), at(v.b), at(v.c), at(v.d))));
    if (!framework_->contact_rule().empty()) {
      if (!reach_holds()) look_up_pairs();
      for (const NearPair& pair : near_) {
        Vec3 d = at(pair.q) - at(pair.p);
        if (box_) d = box_->minimum_image(d);
        largest = std::max(largest, 1 - d.norm() / pair.bound);
      }
    }
    return largest;
  }

  const Vec3& at(int joint) const { return x_[std::size_t(joint)]; }

  ResolveReport finish(ResolveReport& report, StopReason reason) {
    report.reason = reason;
    report.converged =
        reason == StopReason::nothing_broken || reason == StopReason::within_tolerance;
    finite_ = true;
    if (only_moved_bars()) moved_bars_.remember(x_);
    if (report.converged) {
      report.residual = residual();
    } else {
      const Violation worst = worst_violation(*framework_, x_, box_);
      report.residual = worst.relative;
      report.worst = worst.what;
    }
    return report;
  }

  std::shared_ptr<const Framework> framework_;
  ResolverSettings settings_;

  // the order, and what it was made for
  std::vector<SweepBar> sweep_;
  std::vector<int> roots_, middle_joints_;
  bool order_ready_ = false;

  // the break at hand
  std::span<Vec3> x_;
  const Box* box_ = nullptr;
  std::int64_t corrections_ = 0;  ///< in this pass
  std::int64_t held_ = 0;         ///< violated constraints that nothing can move, in this pass
  std::int64_t visits_ = 0;       ///< of bars, in this pass
  int last_problem_ = -1;         ///< bar of the problem constraint corrected last, in this pass
  bool finite_ = true;

  // contacts
  ContactList contact_list_;
  std::vector<NearPair> near_;
  std::vector<Vec3> looked_up_at_;
  bool scattered_ = false;  ///< the last pass gave up looking pairs up anew
  bool had_box_ = false;
  Box last_box_{};

  // our own orders
  MovedBars moved_bars_;
  std::vector<std::uint8_t> dense_;  ///< in a dense cycle block (nbar), where it is asked for
};

}  // namespace

std::unique_ptr<Resolver> make_ordered_resolver(std::shared_ptr<const Framework> framework,
                                                const ResolverSettings& settings) {
  return std::make_unique<OrderedResolver>(std::move(framework), settings);
}

}  // namespace ragdoll
