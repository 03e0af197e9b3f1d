// The thesis' sweep. In doubles on the caller's positions; in floats on a copy of them, which is
// handed back where it holds the tolerance in doubles, and done anew in doubles where not.

#include "resolver_ordered.h"

#include <algorithm>  // copy
#include <optional>
#include <utility>  // move

#include "ordered_passes.h"  // OrderedPasses, conclude_passes
#include "pass_frame.h"      // PassFrame

namespace ragdoll {
namespace {

class OrderedResolver final : public Resolver {
 public:
  OrderedResolver(std::shared_ptr<const Framework> framework, const ResolverSettings& settings)
      : framework_(std::move(framework)), settings_(settings) {
    if (settings.precision == Precision::single) {
      frame_.emplace(*framework_, settings.tolerance);
      singles_.emplace(*framework_, settings);
      x_.resize(3 * std::size_t(framework_->joint_count()));
    } else {
      doubles_.emplace(*framework_, settings);
    }
  }

  std::string solver() const override { return "ordered"; }

  const std::vector<int>* moved_joints() const override {
    return doubles_ && !frame_ ? doubles_->moved_joints() : nullptr;
  }

  ResolveReport resolve(std::span<Vec3> positions, const Breakage& breakage) override {
    ResolveReport report;
    if (frame_ && in_singles(positions, breakage, report)) return report;
    if (!doubles_) doubles_.emplace(*framework_, settings_);
    const OrderedOutcome outcome = doubles_->run(positions.data()->data(), breakage);
    conclude_passes<double>(report, outcome, *framework_, positions, breakage.box,
                            settings_.tolerance, pairs_of(*doubles_, outcome),
                            doubles_->known_residual());
    return report;
  }

 private:
  /// @return false if it has to be done in doubles
  bool in_singles(std::span<Vec3> positions, const Breakage& breakage, ResolveReport& report) {
    if (!frame_->centre(positions)) return false;
    const StridedPoints<float> points = {x_.data(), positions.size()};
    for (std::size_t j = 0; j < positions.size(); ++j) frame_->put(positions[j], points, int(j));
    const OrderedOutcome outcome = singles_->run(x_.data(), breakage);
    if (outcome.reason == StopReason::not_finite) return false;
    before_.assign(positions.begin(), positions.end());
    frame_->take(points, positions);
    const bool holds = conclude_passes<float>(report, outcome, *framework_, positions, breakage.box,
                                              settings_.tolerance, pairs_of(*singles_, outcome));
    if (!holds) std::copy(before_.begin(), before_.end(), positions.begin());
    return holds;
  }

  template <class T>
  static std::span<const NearPair> pairs_of(OrderedPasses<T>& passes,
                                            const OrderedOutcome& outcome) {
    return is_resolved(outcome.reason) ? passes.near_pairs() : std::span<const NearPair>();
  }

  std::shared_ptr<const Framework> framework_;
  ResolverSettings settings_;
  std::optional<OrderedPasses<double>> doubles_;  ///< made when it is needed

  // precision single
  std::optional<PassFrame<float>> frame_;
  std::optional<OrderedPasses<float>> singles_;
  std::vector<float> x_;      ///< (3 njoint)
  std::vector<Vec3> before_;  ///< (njoint)
};

}  // namespace

std::unique_ptr<Resolver> make_ordered_resolver(std::shared_ptr<const Framework> framework,
                                                const ResolverSettings& settings) {
  return std::make_unique<OrderedResolver>(std::move(framework), settings);
}

}  // namespace ragdoll
