// The block sweep. Outward from the root, each bridge 1/0 and each cycle block by Newton with its
// entry joint pinned: what was visited stays within tolerance, so that one sweep does.
//
// Roots. Each component from its first root; further roots in it are joints like the others, they
// keep their places no more than these. Without roots, from middle joints; components that broke
// but have no root, from their lowest joints.
// Fixed joints. If a sweep meets one where it ought to move, a second sweep starts from a fixed
// joint: that always resolves trees. The forced joint then gives way. Two iterations are reported.
// What moved. Breakage::only_roots_moved tells; else all positions are compared with those of the
// last resolved break, bit by bit, because Verlet steps and callers move other joints too. If only
// roots moved, one in each component, the sweep visits what it moves and no more; else all of the
// components that changed. The result is the same, and so it is for a resolver made anew.

#include "resolver_block.h"

#include <algorithm>  // min, max, copy
#include <cstring>    // memcmp
#include <utility>    // move

#include "block_sweep.h"      // BlockSweep
#include "constraints.h"      // has_bars_only, check_roots
#include "resolver_newton.h"  // make_newton_resolver

namespace ragdoll {
namespace {

class BlockResolver final : public Resolver {
 public:
  BlockResolver(std::shared_ptr<const Framework> framework, const ResolverSettings& settings)
      : framework_(std::move(framework)),
        settings_(settings),
        sweep_(*framework_, settings.tolerance),
        resolved_(std::size_t(framework_->joint_count())),
        bars_only_(has_bars_only(*framework_)),
        root_of_(std::size_t(framework_->components().count()), -1),
        changed_in_(root_of_.size(), 0) {
    changed_.reserve(256);
    sweeps_.reserve(16);
    with_root_.reserve(16);
    components_changed_.reserve(16);
  }

  std::string solver() const override { return "block"; }

  const std::vector<int>* moved_joints() const override {
    if (all_changed_ || !bars_only_) return nullptr;
    take_moved();
    return &changed_;
  }

  ResolveReport resolve(std::span<Vec3> positions, const Breakage& breakage) override {
    x_ = positions;
    breakage_ = &breakage;
    check_roots(*framework_, breakage.roots);
    if (!bars_only_ && breakage.roots.empty()) return newton(settings_.max_iterations);
    if (!bars_only_) before_.assign(x_.begin(), x_.end());
    look_for_changes();
    sweeps_.clear();
    ResolveReport report;
    if (!changes_are_finite()) {
      finish(report, StopReason::not_finite);
      return report;
    }

    choose_roots();
    std::int64_t corrections = 0, held = 0;
    second_ruled_out_ = false;
    for (const Start& start : sweeps_) {
      const bool finite = resolve_from(start.root, start.scope, corrections, held, report);
      if (finite) continue;
      finish(report, StopReason::not_finite);
      return report;
    }
    if (!bars_only_) {
      report = finish_others(report);
    } else if (held > 0) {
      finish(report, second_ruled_out_ ? StopReason::max_iterations : StopReason::stagnated);
    } else if (corrections > 0) {
      finish(report, StopReason::within_tolerance);
    } else {
      report.bar_visits = 0;
      finish(report, StopReason::nothing_broken);
    }
    return report;
  }

 private:
  struct Start {
    int root;
    BlockSweep::Scope scope;
  };

  std::size_t component_of(int joint) const {
    return std::size_t(framework_->components().of_joint[std::size_t(joint)]);
  }

  /// The joints that are not where the last resolved break left them; all, if that is not known.
  void look_for_changes() {
    changed_.clear();
    to_take_ = false;
    // with promises alone nobody needs to keep where joints are
    all_changed_ = !known_ || (unkept_ && !breakage_->only_roots_moved);
    if (all_changed_) return;
    if (breakage_->only_roots_moved) {
      unkept_ = true;
      const auto roots = breakage_->roots;
      changed_.assign(roots.begin(), roots.end());
      return;
    }
    const std::size_t count = x_.size();
    constexpr std::size_t chunk = 256;
    for (std::size_t first = 0; first < count; first += chunk) {
      const std::size_t last = std::min(count, first + chunk);
      if (same(first, last - first)) continue;
      for (std::size_t j = first; j < last; ++j)
        if (!same(j, 1)) changed_.push_back(int(j));
    }
  }

  bool same(std::size_t first, std::size_t count) const {
    return std::memcmp(x_[first].data(), resolved_[first].data(), count * sizeof(Vec3)) == 0;
  }

  bool changes_are_finite() const {
    if (all_changed_)
      return std::all_of(x_.begin(), x_.end(), [](const Vec3& point) { return point.allFinite(); });
    return std::all_of(changed_.begin(), changed_.end(),
                       [&](int joint) { return x_[std::size_t(joint)].allFinite(); });
  }

  /// Where the sweeps start, and what they visit.
  void choose_roots() {
    const Components& components = framework_->components();
    with_root_.clear();
    components_changed_.clear();
    for (const int root : breakage_->roots) {
      int& first = root_of_[component_of(root)];
      if (first >= 0) continue;
      first = root;
      with_root_.push_back(int(component_of(root)));
    }
    if (all_changed_) {
      for (int component = 0; component < components.count(); ++component) {
        components_changed_.push_back(component);
        changed_in_[std::size_t(component)] = 2;
      }
    }
    for (const int joint : changed_) {
      // 0: not changed; 1: only its root; 2: other joints
      std::uint8_t& mark = changed_in_[component_of(joint)];
      if (mark == 0) components_changed_.push_back(int(component_of(joint)));
      if (mark < 2) mark = joint == root_of_[component_of(joint)] ? 1 : 2;
    }
    const auto add = [&](int component, int root) {
      std::uint8_t& mark = changed_in_[std::size_t(component)];
      if (mark != 0)
        sweeps_.push_back({root, mark == 1 ? BlockSweep::Scope::moved : BlockSweep::Scope::all});
      mark = 0;
    };
    for (const int component : with_root_) add(component, root_of_[std::size_t(component)]);
    for (const int component : components_changed_)
      if (changed_in_[std::size_t(component)] != 0)
        add(component, breakage_->roots.empty() ? middle_joint(component)
                                                : components.lowest_joint[std::size_t(component)]);
    for (const int component : with_root_) root_of_[std::size_t(component)] = -1;
  }

  int middle_joint(int component) {
    if (middle_joints_.empty()) {
      MiddleJoint middle(framework_->graph());
      for (const int lowest : framework_->components().lowest_joint)
        middle_joints_.push_back(middle.of(lowest));
    }
    return middle_joints_[std::size_t(component)];
  }

  /// One component. @return false if positions got out of the range of numbers
  bool resolve_from(int root, BlockSweep::Scope scope, std::int64_t& corrections,
                    std::int64_t& held, ResolveReport& report) {
    take_moved();
    const int ground = sweep_.tree().ground(int(component_of(root)));
    BlockSweep::Tally tally = sweep_.sweep(x_, root, scope);
    std::int64_t iterations = tally.corrections > 0 || tally.held > 0 ? 1 : 0;
    report.bar_visits += tally.visits;
    const bool second =
        tally.held > 0 && tally.finite && ground >= 0 && !framework_->fixed()[std::size_t(root)];
    if (second && settings_.max_iterations == 1) {
      second_ruled_out_ = true;
    } else if (second) {
      remember_moved();
      take_moved();
      for (const BlockSweep::Moved& moved : sweep_.moved())
        x_[std::size_t(moved.joint)] = moved.was;
      tally = sweep_.sweep(x_, ground, BlockSweep::Scope::all);
      report.bar_visits += tally.visits;
      ++iterations;
    }
    corrections += tally.corrections;
    held += tally.held;
    report.carried += tally.carried;
    report.iterations = std::max(report.iterations, iterations);
    remember_moved();
    return tally.finite;
  }

  /// What the last sweep moved counts as changed; it is written down when somebody asks.
  void remember_moved() {
    take_moved();
    to_take_ = !all_changed_;
  }
  void take_moved() const {
    if (!to_take_) return;
    for (const BlockSweep::Moved& moved : sweep_.moved()) changed_.push_back(moved.joint);
    to_take_ = false;
  }

  /// The constraints that are no bars, and bars that the sweep could not meet. Where that leads
  /// nowhere, without the sweep.
  ResolveReport finish_others(const ResolveReport& swept) {
    known_ = false;
    ResolveReport report = after(swept, newton(settings_.max_iterations - swept.iterations));
    if (report.converged || report.iterations >= settings_.max_iterations) return report;
    std::copy(before_.begin(), before_.end(), x_.begin());
    return after(report, newton(settings_.max_iterations - report.iterations));
  }

  static ResolveReport after(const ResolveReport& first, ResolveReport then) {
    then.iterations += first.iterations;
    then.bar_visits += first.bar_visits;
    then.carried += first.carried;
    if (then.reason == StopReason::nothing_broken && first.iterations > 0)
      then.reason = StopReason::within_tolerance;
    return then;
  }

  /// All constraints at once. @param most  iterations; with none left it only tells what is broken
  ResolveReport newton(long most) {
    if (most < 1) {
      const Violation worst = measure();
      const double largest = settings_.tolerance.absolute() ? worst.nanometers : worst.relative;
      ResolveReport report;
      report.converged = largest <= settings_.tolerance.value();
      report.reason = report.converged ? StopReason::nothing_broken : StopReason::max_iterations;
      report.residual = worst.relative;
      report.residual_nm = worst.nanometers;
      if (!report.converged) report.worst = worst.what;
      return report;
    }
    if (!newton_ || newton_most_ != most) {
      ResolverSettings settings = settings_;
      settings.max_iterations = newton_most_ = most;
      newton_ = make_newton_resolver(framework_, settings);
    }
    Breakage breakage = *breakage_;
    breakage.only_roots_moved = false;
    return newton_->resolve(x_, breakage);
  }

  Violation measure() const {
    return worst_violation(*framework_, x_, breakage_->box, settings_.tolerance);
  }

  void finish(ResolveReport& report, StopReason reason) {
    report.reason = reason;
    report.converged =
        reason == StopReason::nothing_broken || reason == StopReason::within_tolerance;
    if (report.converged) {
      if (all_changed_) {
        std::copy(x_.begin(), x_.end(), resolved_.begin());
        unkept_ = false;
      } else if (!unkept_) {
        take_moved();
        for (const int joint : changed_) resolved_[std::size_t(joint)] = x_[std::size_t(joint)];
      }
      const BarViolation residual = sweep_.residual();
      report.residual = residual.relative;
      report.residual_nm = residual.nanometers;
      known_ = true;
      return;
    }
    // positions that are no numbers were not touched: what was known still is
    known_ = known_ && reason == StopReason::not_finite && sweeps_.empty();
    const Violation worst = measure();
    report.residual = worst.relative;
    report.residual_nm = worst.nanometers;
    report.worst = worst.what;
  }

  std::shared_ptr<const Framework> framework_;
  ResolverSettings settings_;
  BlockSweep sweep_;
  std::vector<Vec3> resolved_;  ///< by the last break that was (njoint)
  bool unkept_ = false;         ///< joints have moved since, by breaks that promised
  bool known_ = false;          ///< every bar's violation is that of resolved_
  std::vector<int> middle_joints_;

  bool bars_only_;
  std::unique_ptr<Resolver> newton_;  ///< of frameworks with other constraints, once needed
  long newton_most_ = 0;              ///< iterations that it is made for

  // the break at hand
  std::span<Vec3> x_;
  const Breakage* breakage_ = nullptr;
  bool all_changed_ = true;
  std::vector<Vec3> before_;          ///< positions, where there are other constraints
  mutable std::vector<int> changed_;  ///< joints, those that a sweep moved too; of no use if all
                                      ///< changed
  mutable bool to_take_ = false;      ///< those of the last sweep are not in it yet
  std::vector<int> root_of_;          ///< -1: none (ncomponent)
  std::vector<std::uint8_t> changed_in_;  ///< (ncomponent)
  std::vector<Start> sweeps_;
  std::vector<int> with_root_, components_changed_;  ///< components
  bool second_ruled_out_ = false;                    ///< by a maximum of one iteration
};

}  // namespace

std::unique_ptr<Resolver> make_block_resolver(std::shared_ptr<const Framework> framework,
                                              const ResolverSettings& settings) {
  return std::make_unique<BlockResolver>(std::move(framework), settings);
}

}  // namespace ragdoll
