#include "ragdoll/ensemble_resolver.h"

#include <algorithm>  // copy
#include <utility>    // move

#include "ensemble_newton.h"   // make_newton_ensemble
#include "ensemble_ordered.h"  // make_ordered_ensemble
#include "ragdoll/error.h"     // Error

namespace ragdoll {
namespace {

/// For solvers that have no lanes, and for single ones, which would leave vectors nearly empty: one
/// Resolver, which resolves when it iterates.
class InTurn final : public EnsembleResolver {
 public:
  InTurn(int joints, std::unique_ptr<Resolver> resolver)
      : joints_(std::size_t(joints)), resolver_(std::move(resolver)) {}

  int lanes() const override { return 1; }
  std::size_t joint_count() const override { return joints_; }
  std::string instructions() const override { return "none"; }
  std::string solver() const override { return resolver_->solver(); }

  void load(int, std::span<const Vec3> positions, const Breakage& breakage) override {
    positions_.assign(positions.begin(), positions.end());
    breakage_ = breakage;
    done_ = false;
  }
  void iterate() override {
    if (done_) return;
    report_ = resolver_->resolve(positions_, breakage_);
    done_ = true;
  }
  bool done(int) const override { return done_; }
  ResolveReport unload(int, std::span<Vec3> positions) override {
    std::copy(positions_.begin(), positions_.end(), positions.begin());
    return report_;
  }

 private:
  std::size_t joints_;
  std::unique_ptr<Resolver> resolver_;
  std::vector<Vec3> positions_;
  Breakage breakage_;
  ResolveReport report_;
  bool done_ = true;
};

}  // namespace

std::unique_ptr<EnsembleResolver> make_ensemble_resolver(std::shared_ptr<const Framework> framework,
                                                         const ResolverSettings& settings,
                                                         int lanes) {
  if (lanes < 0) throw Error("the number of lanes must be 0 or more");
  std::unique_ptr<Resolver> alone = make_resolver(framework, settings);
  if (lanes == 1) return std::make_unique<InTurn>(framework->joint_count(), std::move(alone));
  if (alone->solver() == "ordered" && ordered_lanes_fit(settings))
    return make_ordered_ensemble(std::move(framework), settings, lanes, std::move(alone));
  if (alone->solver() == "newton")
    return make_newton_ensemble(std::move(framework), settings, lanes);
  return std::make_unique<InTurn>(framework->joint_count(), std::move(alone));
}

std::vector<ResolveReport> resolve_all(EnsembleResolver& resolver, std::span<Vec3> positions,
                                       std::uint64_t first_step, const Box* box) {
  const std::size_t joints = resolver.joint_count();
  const std::size_t count = joints == 0 ? 0 : positions.size() / joints;
  std::vector<ResolveReport> reports(count);
  std::vector<std::size_t> in_lane(std::size_t(resolver.lanes()), count);  // count: free
  std::size_t next = 0, finished = 0;
  while (finished < count) {
    for (std::size_t lane = 0; lane < in_lane.size(); ++lane) {
      std::size_t& conformer = in_lane[lane];
      if (conformer != count && resolver.done(int(lane))) {
        reports[conformer] =
            resolver.unload(int(lane), positions.subspan(conformer * joints, joints));
        conformer = count;
        ++finished;
      }
      if (conformer == count && next < count) {
        conformer = next++;
        resolver.load(int(lane), positions.subspan(conformer * joints, joints),
                      {.step = first_step + conformer, .box = box});
      }
    }
    resolver.iterate();
  }
  return reports;
}

}  // namespace ragdoll
