// The thesis' sweep, in doubles. bfs_active and bfs_worst are ours: they leave out the bars that
// nothing moved since they were last found within tolerance.

#include "resolver_ordered.h"

#include <utility>  // move

#include "conclusion.h"      // conclude, residual_of
#include "ordered_passes.h"  // OrderedPasses

namespace ragdoll {
namespace {

class OrderedResolver final : public Resolver {
 public:
  OrderedResolver(std::shared_ptr<const Framework> framework, const ResolverSettings& settings)
      : framework_(std::move(framework)),
        tolerance_(settings.tolerance),
        passes_(*framework_, settings) {}

  std::string solver() const override { return "ordered"; }

  ResolveReport resolve(std::span<Vec3> positions, const Breakage& breakage) override {
    const auto outcome = passes_.run(positions.data()->data(), breakage);
    ResolveReport report;
    report.iterations = outcome.iterations;
    report.bar_visits = outcome.bar_visits;
    Residual residual;
    if (is_resolved(outcome.reason))
      residual =
          residual_of(*framework_, positions, breakage.box, tolerance_, passes_.near_pairs());
    conclude(report, outcome.reason, *framework_, positions, breakage.box, tolerance_, residual);
    return report;
  }

 private:
  std::shared_ptr<const Framework> framework_;
  Tolerance tolerance_;
  OrderedPasses<double> passes_;
};

}  // namespace

std::unique_ptr<Resolver> make_ordered_resolver(std::shared_ptr<const Framework> framework,
                                                const ResolverSettings& settings) {
  return std::make_unique<OrderedResolver>(std::move(framework), settings);
}

}  // namespace ragdoll
