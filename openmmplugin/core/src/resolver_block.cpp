// The block sweep. Bars only. Outward from the root, each bridge 1/0 and each cycle block by Newton
// with its entry joint pinned: what was visited stays within tolerance, so that one sweep does.
//
// Roots. Each component from its first root; further roots in it are joints like the others, they
// keep their places no more than these. Without roots, from middle joints; components that broke
// but have no root, from their lowest joints.
// Fixed joints. If a sweep meets one where it ought to move, a second sweep starts from a fixed
// joint: that always resolves trees. The forced joint then gives way. Two iterations are reported.
// What moved is found by comparing all positions with those of the last resolved break, bit by bit:
// roots do not tell, Verlet steps and callers move other joints too. If only roots moved, one in
// each component, the sweep visits what it moves and no more; else all of the components that
// changed. The result is the same.

#include "resolver_block.h"

#include <algorithm>  // min, copy
#include <cmath>      // isfinite
#include <cstring>    // memcmp
#include <string>
#include <utility>  // move

#include "block_sweep.h"    // BlockSweep
#include "ragdoll/error.h"  // Error

namespace ragdoll {
namespace {

class BlockResolver final : public Resolver {
 public:
  BlockResolver(std::shared_ptr<const Framework> framework, const ResolverSettings& settings)
      : framework_(std::move(framework)),
        settings_(settings),
        sweep_(*framework_, settings.tolerance.value()),
        root_of_(std::size_t(framework_->components().count()), -1),
        changed_in_(root_of_.size(), 0) {}

  std::string solver() const override { return "block"; }

  ResolveReport resolve(std::span<Vec3> positions, const Breakage& breakage) override {
    x_ = positions;
    box_ = breakage.box;
    check_roots(breakage.roots);
    look_for_changes();
    sweeps_.clear();
    ResolveReport report;
    for (const int joint : changed_)
      if (!x_[std::size_t(joint)].allFinite()) return finish(report, StopReason::not_finite);

    choose_roots(breakage.roots);
    std::int64_t corrections = 0, held = 0;
    second_ruled_out_ = false;
    for (const Start& start : sweeps_) {
      const bool finite = resolve_from(start.root, start.scope, corrections, held, report);
      if (!finite) return finish(report, StopReason::not_finite);
    }
    if (held > 0)
      return finish(report, second_ruled_out_ ? StopReason::max_iterations : StopReason::stagnated);
    if (corrections > 0) return finish(report, StopReason::within_tolerance);
    report.bar_visits = 0;
    return finish(report, StopReason::nothing_broken);
  }

 private:
  struct Start {
    int root;
    BlockSweep::Scope scope;
  };

  void check_roots(std::span<const int> roots) const {
    for (const int root : roots)
      if (root < 0 || root >= framework_->joint_count())
        throw Error("root " + std::to_string(root) + " is no joint; there are " +
                    std::to_string(framework_->joint_count()));
  }

  int component_of(int joint) const {
    return framework_->components().of_joint[std::size_t(joint)];
  }

  /// The joints that are not where the last resolved break left them; all, if that is not known.
  void look_for_changes() {
    changed_.clear();
    const std::size_t count = x_.size();
    if (!known_) {
      for (std::size_t j = 0; j < count; ++j) changed_.push_back(int(j));
      return;
    }
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

  /// Where the sweeps start, and what they visit.
  void choose_roots(std::span<const int> roots) {
    const Components& components = framework_->components();
    with_root_.clear();
    components_changed_.clear();
    for (const int root : roots) {
      int& first = root_of_[std::size_t(component_of(root))];
      if (first >= 0) continue;
      first = root;
      with_root_.push_back(component_of(root));
    }
    for (const int joint : changed_) {
      // 0: not changed; 1: only its root; 2: other joints
      const int component = component_of(joint);
      std::uint8_t& mark = changed_in_[std::size_t(component)];
      if (mark == 0) components_changed_.push_back(component);
      if (mark < 2) mark = joint == root_of_[std::size_t(component)] && known_ ? 1 : 2;
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
        add(component, roots.empty() ? middle_joint(component)
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
    const int ground = sweep_.tree().ground[std::size_t(component_of(root))];
    std::vector<Vec3> before;
    const Vec3 forced = x_[std::size_t(root)];
    if (ground >= 0 && scope == BlockSweep::Scope::all) before.assign(x_.begin(), x_.end());

    BlockSweep::Tally tally = sweep_.sweep(x_, resolved_, root, scope);
    std::int64_t iterations = tally.corrections > 0 || tally.held > 0 ? 1 : 0;
    report.bar_visits += tally.visits;
    const bool second =
        tally.held > 0 && tally.finite && ground >= 0 && !framework_->fixed()[std::size_t(root)];
    if (second && settings_.max_iterations == 1) {
      second_ruled_out_ = true;
    } else if (second) {
      if (before.empty()) {
        for (const int joint : sweep_.moved())
          x_[std::size_t(joint)] = resolved_[std::size_t(joint)];
        x_[std::size_t(root)] = forced;
      } else {
        std::copy(before.begin(), before.end(), x_.begin());
      }
      remember_moved();
      tally = sweep_.sweep(x_, resolved_, ground, BlockSweep::Scope::all);
      report.bar_visits += tally.visits;
      ++iterations;
    }
    corrections += tally.corrections;
    held += tally.held;
    report.iterations = std::max(report.iterations, iterations);
    remember_moved();
    return tally.finite;
  }

  void remember_moved() {
    const auto moved = sweep_.moved();
    changed_.insert(changed_.end(), moved.begin(), moved.end());
  }

  ResolveReport finish(ResolveReport& report, StopReason reason) {
    report.reason = reason;
    report.converged =
        reason == StopReason::nothing_broken || reason == StopReason::within_tolerance;
    if (report.converged) {
      if (resolved_.empty())
        resolved_.assign(x_.begin(), x_.end());
      else
        for (const int joint : changed_) resolved_[std::size_t(joint)] = x_[std::size_t(joint)];
      report.residual = sweep_.residual();
      known_ = true;
      return report;
    }
    // positions that are no numbers were not touched: what was known still is
    known_ =
        known_ && reason == StopReason::not_finite && report.iterations == 0 && sweeps_.empty();
    const Violation worst = worst_violation(*framework_, x_, box_);
    report.residual = worst.relative;
    report.worst = worst.what;
    return report;
  }

  std::shared_ptr<const Framework> framework_;
  ResolverSettings settings_;
  BlockSweep sweep_;
  std::vector<Vec3> resolved_;  ///< by the last break that was; empty: none was (njoint)
  bool known_ = false;          ///< every bar's violation is that of resolved_
  std::vector<int> middle_joints_;

  // the break at hand
  std::span<Vec3> x_;
  const Box* box_ = nullptr;
  std::vector<int> changed_;              ///< joints; those that a sweep moved are added
  std::vector<int> root_of_;              ///< -1: none (ncomponent)
  std::vector<std::uint8_t> changed_in_;  ///< (ncomponent)
  std::vector<Start> sweeps_;
  std::vector<int> with_root_, components_changed_;  ///< components
  bool second_ruled_out_ = false;                    ///< by a maximum of one iteration
};

void refuse(const char* what) {
  throw Error(std::string("solver block holds bars only, and this framework has ") + what +
              "; choose solver ordered");
}

}  // namespace

std::unique_ptr<Resolver> make_block_resolver(std::shared_ptr<const Framework> framework,
                                              const ResolverSettings& settings) {
  if (!framework->tethers().empty()) refuse("tethers");
  if (!framework->contacts().empty() || !framework->contact_rule().empty()) refuse("contacts");
  if (!framework->volumes().empty()) refuse("chirality or planarity volumes");
  return std::make_unique<BlockResolver>(std::move(framework), settings);
}

}  // namespace ragdoll
