// Lanes of `newton`. One iteration is a Newton step in every lane that is busy, and the sweep
// before it in those just loaded; lanes are at different steps side by side, each with its own mu,
// and one that has ended is left alone until it is loaded anew. What is rare is done by the
// Resolver of one conformer, from where the lane was loaded: stagnation and repairs, positions that
// are no numbers, what floats cannot resolve.

#include "ensemble_newton.h"

#include <algorithm>  // copy, max
#include <utility>    // move

#include "newton_engine.h"         // NewtonEngine
#include "resolver_newton.h"       // make_newton_resolver, conclude_newton
#include "resolver_newton_bars.h"  // plan_newton_bars, make_newton_bars_ensemble

namespace ragdoll {
namespace {

class NewtonEnsemble final : public EnsembleResolver {
 public:
  NewtonEnsemble(std::shared_ptr<const NewtonTask> task, int lanes) : task_(std::move(task)) {
    do {
      engines_.push_back(make_newton_engine(task_, task_->settings.precision, false));
      width_ = std::size_t(engines_.back()->lanes());
    } while (int(engines_.size() * width_) < lanes && !task_->plan.is_bulky);
    // what is made without a factor fills the vectors by itself, and the caches: in turn
    lanes_.resize(lanes > 0 && !task_->plan.is_bulky ? std::size_t(lanes) : width_);
  }

  int lanes() const override { return int(lanes_.size()); }
  std::size_t joint_count() const override { return std::size_t(task_->framework->joint_count()); }
  std::string instructions() const override { return newton_instructions(); }
  std::string solver() const override { return "newton"; }

  void load(int lane, std::span<const Vec3> positions, const Breakage& breakage) override {
    Lane& it = lanes_[std::size_t(lane)];
    it.start.assign(positions.begin(), positions.end());
    it.breakage = breakage;
    engine_of(lane).load(place_of(lane), positions, breakage.box, task_->settings.max_iterations);
  }

  void iterate() override {
    for (const auto& engine : engines_) engine->iterate();
  }

  bool done(int lane) const override {
    return engines_[std::size_t(lane) / width_]->done(place_of(lane));
  }

  ResolveReport unload(int lane, std::span<Vec3> positions) override {
    const Lane& it = lanes_[std::size_t(lane)];
    std::copy(it.start.begin(), it.start.end(), positions.begin());
    const NewtonEnd end = engine_of(lane).unload(place_of(lane), positions);
    ResolveReport report;
    report.iterations = end.iterations;
    report.bar_visits = bar_visits_of(end, *task_->framework);
    if (conclude_newton(end, report)) return report;
    if (!alone_) alone_ = make_newton_resolver(task_);
    std::copy(it.start.begin(), it.start.end(), positions.begin());
    return alone_->resolve(positions, it.breakage);
  }

 private:
  struct Lane {
    std::vector<Vec3> start;  ///< as loaded (njoint)
    Breakage breakage;
  };

  NewtonEngine& engine_of(int lane) { return *engines_[std::size_t(lane) / width_]; }
  int place_of(int lane) const { return int(std::size_t(lane) % width_); }

  std::shared_ptr<const NewtonTask> task_;
  std::vector<std::unique_ptr<NewtonEngine>> engines_;
  std::size_t width_ = 0;  ///< lanes of an engine
  std::vector<Lane> lanes_;
  std::unique_ptr<Resolver> alone_;  ///< made when first needed
};

}  // namespace

std::unique_ptr<EnsembleResolver> make_newton_ensemble(std::shared_ptr<const Framework> framework,
                                                       const ResolverSettings& settings,
                                                       int lanes) {
  if (auto plan = plan_newton_bars(*framework, settings))
    return make_newton_bars_ensemble(std::move(framework), settings, std::move(plan), lanes);
  return make_newton_ensemble(std::make_shared<const NewtonTask>(std::move(framework), settings),
                              lanes);
}

std::unique_ptr<EnsembleResolver> make_newton_ensemble(std::shared_ptr<const NewtonTask> task,
                                                       int lanes) {
  return std::make_unique<NewtonEnsemble>(std::move(task), lanes);
}

}  // namespace ragdoll
