// The reference method of FRODA (Wells, Menor, Hespenheide and Thorpe, Phys. Biol. 2, S127, 2005):
// each rigid unit has a template, a ghost of its shape. In each iteration every template is laid
// over its joints by least squares, every joint goes to the mean of its places in the templates
// that hold it, and then tethers, contacts and volumes are corrected one by one. Orders and
// weightings have no meaning here.

#include "resolver_templates.h"

#include <algorithm>  // all_of, max
#include <cmath>      // abs, sin, cos
#include <utility>    // move

#include "conclusion.h"             // conclude, residual_of
#include "ordered_passes.h"         // OrderedPasses
#include "ragdoll/rigid_units.h"    // find_rigid_units
#include "ragdoll/superposition.h"  // superposition, superposed_rmsd

namespace ragdoll {
namespace {

/// The framework without its bars: what a pass corrects beside the templates.
std::shared_ptr<const Framework> without_bars(const Framework& framework) {
  FrameworkParts parts = framework.parts();
  parts.bars.clear();
  return std::make_shared<const Framework>(std::move(parts));
}

ResolverSettings one_pass(ResolverSettings settings) {
  settings.max_iterations = 1;
  settings.order = OrderKind::bfs_cycle;
  settings.custom_order.clear();
  settings.work_list = false;
  return settings;
}

class TemplatesResolver final : public Resolver {
 public:
  TemplatesResolver(std::shared_ptr<const Framework> framework, const ResolverSettings& settings)
      : framework_(std::move(framework)),
        settings_(settings),
        units_(find_rigid_units(*framework_)),
        rest_framework_(without_bars(*framework_)),
        rest_(*rest_framework_, one_pass(settings)),
        held_by_(framework_->masses().size()),
        sum_(framework_->masses().size()) {
    for (const RigidUnit& unit : units_)
      for (const int joint : unit.joints) ++held_by_[std::size_t(joint)];
    has_rest_ = !framework_->tethers().empty() || !framework_->contacts().empty() ||
                !framework_->volumes().empty() || !framework_->contact_rule().empty();
  }

  std::string solver() const override { return "templates"; }

  ResolveReport resolve(std::span<Vec3> positions, const Breakage& breakage) override {
    ResolveReport report;
    StopReason reason = StopReason::nothing_broken;
    if (!all_finite(positions)) reason = StopReason::not_finite;
    while (reason != StopReason::not_finite && !within(positions, breakage.box)) {
      reason = StopReason::max_iterations;
      if (report.iterations == settings_.max_iterations) break;
      ++report.iterations;
      report.bar_visits += std::int64_t(framework_->bars().size());
      lay_templates(positions);
      if (has_rest_)
        rest_.run(positions.data()->data(), {.step = breakage.step, .box = breakage.box});
      reason = all_finite(positions) ? StopReason::within_tolerance : StopReason::not_finite;
    }
    const Residual residual =
        is_resolved(reason) ? residual_of(*framework_, positions, breakage.box, settings_.tolerance,
                                          near_pairs(positions, breakage.box))
                            : Residual();
    conclude(report, reason, *framework_, positions, breakage.box, settings_.tolerance, residual);
    return report;
  }

 private:
  static bool all_finite(std::span<const Vec3> positions) {
    return std::all_of(positions.begin(), positions.end(),
                       [](const Vec3& point) { return point.allFinite(); });
  }

  /// Bars are looked at first: while they are off, nothing else has to be.
  bool within(std::span<const Vec3> positions, const Box* box) {
    for (const Bar& bar : framework_->bars()) {
      const double d = (positions[std::size_t(bar.q)] - positions[std::size_t(bar.p)]).norm();
      if (!(std::abs(d - bar.length) <= settings_.tolerance.slack(bar.length))) return false;
    }
    return residual_of(*framework_, positions, box, settings_.tolerance, near_pairs(positions, box))
        .within;
  }

  /// The pairs of the contact rule that are nearer than their bounds.
  std::span<const NearPair> near_pairs(std::span<const Vec3> positions, const Box* box) {
    if (framework_->contact_rule().empty()) return {};
    near_.update(positions, box, 0);
    return near_.pairs();
  }

  void lay_templates(std::span<Vec3> positions) {
    std::fill(sum_.begin(), sum_.end(), Vec3::Zero());
    for (const RigidUnit& unit : units_) {
      if (unit.joints.size() == 2)
        lay_bar(unit, positions);
      else
        lay_body(unit, positions);
    }
    for (std::size_t j = 0; j < sum_.size(); ++j)
      if (held_by_[j] > 0 && !framework_->fixed()[j]) positions[j] = sum_[j] / double(held_by_[j]);
  }

  /// Two joints: the bar at its length about its middle.
  void lay_bar(const RigidUnit& unit, std::span<const Vec3> positions) {
    const std::size_t p = std::size_t(unit.joints[0]), q = std::size_t(unit.joints[1]);
    const Vec3 middle = (positions[p] + positions[q]) / 2;
    Vec3 along = positions[q] - positions[p];
    const double length = along.norm();
    // at one place they part in a direction of their own, so that not all end on one line
    if (length > 0)
      along /= length;
    else
      along =
          Vec3(std::sin(double(p) + 1), std::cos(double(q)), std::sin(double(p + q))).normalized();
    const double half = unit.shape[1][0];
    sum_[p] += middle - half * along;
    sum_[q] += middle + half * along;
  }

  void lay_body(const RigidUnit& unit, std::span<const Vec3> positions) {
    at_.clear();
    for (const int joint : unit.joints) at_.push_back(positions[std::size_t(joint)]);
    const std::vector<Vec3>* shape = &unit.shape;
    if (unit.either_hand) {
      mirror_ = unit.shape;
      for (Vec3& point : mirror_) point[2] = -point[2];
      if (superposed_rmsd(mirror_, at_) < superposed_rmsd(unit.shape, at_)) shape = &mirror_;
    }
    const RigidMove move = superposition(*shape, at_);
    for (std::size_t k = 0; k < unit.joints.size(); ++k)
      sum_[std::size_t(unit.joints[k])] += move((*shape)[k]);
  }

  std::shared_ptr<const Framework> framework_;
  ResolverSettings settings_;
  std::vector<RigidUnit> units_;
  std::shared_ptr<const Framework> rest_framework_;
  OrderedPasses<double> rest_;
  bool has_rest_ = false;
  ContactList near_{framework_->contact_rule(), 1e-9};
  std::vector<int> held_by_;  ///< how many units (njoint)
  std::vector<Vec3> sum_;     ///< of the places in templates, nm (njoint)
  std::vector<Vec3> at_, mirror_;
};

}  // namespace

std::unique_ptr<Resolver> make_templates_resolver(std::shared_ptr<const Framework> framework,
                                                  const ResolverSettings& settings) {
  return std::make_unique<TemplatesResolver>(std::move(framework), settings);
}

}  // namespace ragdoll
