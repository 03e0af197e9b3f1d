// All constraints at once: a few Gauss-Seidel sweeps take out what is rough, Levenberg-Marquardt
// the rest. Its cost is that of factoring a sparse matrix, linear in the joints where the framework
// is long rather than bulky, as molecules are; bulky ones go by conjugate gradients.

#include "resolver_newton.h"

#include <algorithm>  // copy
#include <cmath>      // isfinite
#include <optional>   // nullopt
#include <utility>    // move

#include "newton_engine.h"         // NewtonEngine, NewtonTask
#include "newton_repair.h"         // NewtonRepair
#include "resolver_newton_bars.h"  // plan_newton_bars, make_newton_bars_resolver

namespace ragdoll {
namespace {

/// How often traps are looked for.
constexpr int most_repairs = 12;

bool resolved(StopReason reason) {
  return reason == StopReason::nothing_broken || reason == StopReason::within_tolerance;
}

class NewtonResolver final : public Resolver {
 public:
  NewtonResolver(std::shared_ptr<const Framework> framework, const ResolverSettings& settings)
      : NewtonResolver(std::make_shared<const NewtonTask>(std::move(framework), settings)) {}
  explicit NewtonResolver(std::shared_ptr<const NewtonTask> task) : task_(std::move(task)) {
    // what the first break would wait for else
    engine_of(precision());
  }

  std::string solver() const override { return "newton"; }

  ResolveReport resolve(std::span<Vec3> positions, const Breakage& breakage) override {
    report_ = {};
    NewtonEnd end;
    bool ended = false;
    if (precision() == Precision::single) {
      end = run(Precision::single, positions, breakage.box);
      ended = resolved(end.reason) || left() == 0;
    }
    // what floats cannot do, doubles go on with
    if (!ended) end = run(Precision::double_, positions, breakage.box);
    if (end.reason == StopReason::stagnated && !task_->plan.far.empty() && left() > 0)
      end = run_whole(positions, breakage.box);
    for (int round = 0; end.reason == StopReason::stagnated && round < most_repairs; ++round)
      if (!repair(round, positions, breakage.box, end)) break;
    return finish(end, positions, breakage.box);
  }

 private:
  /// What is made without a factor is made in doubles.
  Precision precision() const {
    return task_->plan.is_bulky ? Precision::double_ : task_->settings.precision;
  }

  std::int64_t left() const { return task_->settings.max_iterations - report_.iterations; }

  NewtonEngine& engine_of(Precision precision) {
    std::unique_ptr<NewtonEngine>& engine = precision == Precision::single ? singles_ : doubles_;
    if (!engine) engine = make_newton_engine(task_, precision, true);
    return *engine;
  }

  NewtonEnd run(Precision precision, std::span<Vec3> positions, const Box* box) {
    return run(engine_of(precision), positions, box);
  }

  NewtonEnd run(NewtonEngine& engine, std::span<Vec3> positions, const Box* box) {
    engine.load(0, positions, box, left());
    while (!engine.done(0)) engine.iterate();
    const NewtonEnd end = engine.unload(0, positions);
    report_.iterations += end.iterations;
    report_.bar_visits += bar_visits_of(end, *task_->framework);
    return end;
  }

  /// Many tight tethers far across, which each hold only their own ends, go wrong together: then
  /// they are rows of the pattern.
  NewtonEnd run_whole(std::span<Vec3> positions, const Box* box) {
    if (!whole_)
      whole_ = make_newton_engine(
          std::make_shared<const NewtonTask>(task_->framework, task_->settings, std::nullopt, true),
          Precision::double_, true);
    return run(*whole_, positions, box);
  }

  /// @return false if nothing got better
  bool repair(int round, std::span<Vec3> positions, const Box* box, NewtonEnd& end) {
    if (left() == 0) return false;
    if (!repair_) repair_ = std::make_unique<NewtonRepair>(task_->framework, task_->settings);
    const NewtonRepair::Result result = repair_->repair(positions, box, round, left());
    report_.iterations += result.iterations;
    report_.bar_visits += result.bar_visits;
    if (result.repaired == 0) return false;
    if (left() == 0) {
      end.reason = StopReason::max_iterations;
      return false;
    }
    end = run(Precision::double_, positions, box);
    return true;
  }

  ResolveReport finish(const NewtonEnd& end, std::span<const Vec3> positions, const Box* box) {
    conclude_newton(end, report_);
    if (report_.converged) return report_;
    report_.reason = end.reason;
    const Violation worst =
        worst_violation(*task_->framework, positions, box, task_->settings.tolerance);
    report_.residual = worst.relative;
    report_.residual_nm = worst.nanometers;
    report_.worst = worst.what;
    return report_;
  }

  std::shared_ptr<const NewtonTask> task_;
  std::unique_ptr<NewtonEngine> doubles_, singles_;  ///< the other one when first needed
  std::unique_ptr<NewtonEngine> whole_;  ///< of all constraints' pattern; made when first needed
  std::unique_ptr<NewtonRepair> repair_;
  ResolveReport report_;  ///< of the break at hand
};

}  // namespace

std::int64_t bar_visits_of(const NewtonEnd& end, const Framework& framework) {
  return (end.iterations + end.passes) * std::int64_t(framework.bars().size());
}

bool conclude_newton(const NewtonEnd& end, ResolveReport& report) {
  report.converged = resolved(end.reason);
  if (!report.converged) return false;
  // what a repair or another precision resolved was broken before
  report.reason = report.iterations > 0 ? StopReason::within_tolerance : StopReason::nothing_broken;
  report.residual = end.residual;
  report.residual_nm = end.residual_nm;
  return true;
}

std::unique_ptr<Resolver> make_newton_resolver(std::shared_ptr<const NewtonTask> task) {
  return std::make_unique<NewtonResolver>(std::move(task));
}

std::unique_ptr<Resolver> make_newton_resolver(std::shared_ptr<const Framework> framework,
                                               const ResolverSettings& settings) {
  if (auto plan = plan_newton_bars(*framework, settings))
    return make_newton_bars_resolver(std::move(framework), settings, std::move(plan));
  return make_general_newton_resolver(std::move(framework), settings);
}

std::unique_ptr<Resolver> make_general_newton_resolver(std::shared_ptr<const Framework> framework,
                                                       const ResolverSettings& settings) {
  return std::make_unique<NewtonResolver>(std::move(framework), settings);
}

}  // namespace ragdoll
