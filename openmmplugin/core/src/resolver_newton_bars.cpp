#include "resolver_newton_bars.h"

#include <algorithm>    // copy, min
#include <type_traits>  // is_same
#include <utility>      // move

#include "conclusion.h"       // residual_of
#include "newton_bars.h"      // NewtonBars
#include "ragdoll/error.h"    // Error
#include "resolver_newton.h"  // make_general_newton_resolver

namespace ragdoll {
namespace {

/// Before the rest is left to `newton` for all frameworks.
constexpr int most_steps = 12;

template <class T>
using Steps = std::unique_ptr<NewtonBars<T>>;

/// @return null where floats cannot hold the tolerance
Steps<float> make_singles(const std::shared_ptr<const NewtonBarsPlan>& plan,
                          const Framework& framework, const Tolerance& tolerance, bool wide) {
  try {
    return std::make_unique<NewtonBars<float>>(plan, framework, tolerance, wide);
  } catch (const Error&) {
    return nullptr;
  }
}

/// Takes a lane's result. @param most  iterations of a report
/// @param positions  where they are not the caller's own: of any values
/// @return false if it is not resolved, in doubles; positions are as loaded, if iterations are left
template <class T>
bool conclude_steps(NewtonBars<T>& steps, int lane, std::span<const Vec3> start,
                    std::span<Vec3> positions, const Framework& framework,
                    const Tolerance& tolerance, long most, ResolveReport& report) {
  if (steps.state(lane) == NewtonBars<T>::State::ended) {
    const int count = steps.steps(lane);
    const Residual residual = steps.unload(lane, positions)
                                  ? steps.residual(lane)
                                  : residual_of(framework, positions, nullptr, tolerance);
    if (residual.within) {
      report.converged = true;
      report.iterations += count;
      report.bar_visits = report.iterations * std::int64_t(framework.bars().size());
      report.reason =
          report.iterations > 0 ? StopReason::within_tolerance : StopReason::nothing_broken;
      report.residual = residual.relative;
      report.residual_nm = residual.nanometers;
      return true;
    }
    std::copy(start.begin(), start.end(), positions.begin());
    report.iterations += count;
    return false;
  }
  // where nothing but their number ended the steps, they are what there is
  report.iterations += steps.steps(lane);
  report.bar_visits = report.iterations * std::int64_t(framework.bars().size());
  if (report.iterations == most) {
    steps.unload(lane, positions);
  } else {
    steps.free(lane);
    std::copy(start.begin(), start.end(), positions.begin());
  }
  return false;
}

class NewtonBarsResolver final : public Resolver {
 public:
  NewtonBarsResolver(std::shared_ptr<const Framework> framework, const ResolverSettings& settings,
                     std::shared_ptr<const NewtonBarsPlan> plan)
      : framework_(std::move(framework)), settings_(settings), plan_(std::move(plan)) {
    if (settings.precision == Precision::single)
      singles_ = make_singles(plan_, *framework_, settings.tolerance, false);
  }

  std::string solver() const override { return "newton"; }

  ResolveReport resolve(std::span<Vec3> positions, const Breakage& breakage) override {
    ResolveReport report;
    if (singles_ && run(*singles_, positions, report)) return report;
    if (!doubles_)
      doubles_ =
          std::make_unique<NewtonBars<double>>(plan_, *framework_, settings_.tolerance, false);
    if (run(*doubles_, positions, report)) return report;
    const long left = settings_.max_iterations - long(report.iterations);
    if (left > 0) return generally(positions, breakage, report.iterations, left);
    conclude(report, StopReason::max_iterations, *framework_, positions, nullptr,
             settings_.tolerance, {});
    return report;
  }

 private:
  template <class T>
  bool run(NewtonBars<T>& steps, std::span<Vec3> positions, ResolveReport& report) {
    const long left = settings_.max_iterations - long(report.iterations);
    const int most = int(std::min<long>(most_steps, left));
    if (std::is_same_v<T, double>) {
      start_.assign(positions.begin(), positions.end());
      steps.load_in_place(positions, most);
    } else {
      steps.load(0, positions, start_, most);
    }
    while (steps.state(0) == NewtonBars<T>::State::busy) steps.iterate();
    return conclude_steps(steps, 0, start_, positions, *framework_, settings_.tolerance,
                          settings_.max_iterations, report);
  }

  ResolveReport generally(std::span<Vec3> positions, const Breakage& breakage,
                          std::int64_t iterations, long left) {
    if (!general_ || general_left_ != left) {
      ResolverSettings settings = settings_;
      settings.max_iterations = general_left_ = left;
      general_ = make_general_newton_resolver(framework_, settings);
    }
    ResolveReport report = general_->resolve(positions, breakage);
    if (report.reason == StopReason::nothing_broken && iterations > 0)
      report.reason = StopReason::within_tolerance;
    report.iterations += iterations;
    report.bar_visits += iterations * std::int64_t(framework_->bars().size());
    return report;
  }

  std::shared_ptr<const Framework> framework_;
  ResolverSettings settings_;
  std::shared_ptr<const NewtonBarsPlan> plan_;
  Steps<float> singles_;
  Steps<double> doubles_;              ///< made when needed
  std::unique_ptr<Resolver> general_;  ///< made when needed
  long general_left_ = 0;              ///< iterations that it is made for
  std::vector<Vec3> start_;
};

template <class T>
class NewtonBarsEnsemble final : public EnsembleResolver {
 public:
  NewtonBarsEnsemble(std::shared_ptr<const Framework> framework, const ResolverSettings& settings,
                     std::shared_ptr<const NewtonBarsPlan> plan, Steps<T> first, int lanes)
      : framework_(std::move(framework)), settings_(settings), plan_(std::move(plan)) {
    width_ = std::size_t(first->lanes());
    steps_.push_back(std::move(first));
    while (int(steps_.size() * width_) < lanes)
      steps_.push_back(
          std::make_unique<NewtonBars<T>>(plan_, *framework_, settings.tolerance, true));
    lanes_.resize(lanes > 0 ? std::size_t(lanes) : width_);
  }

  int lanes() const override { return int(lanes_.size()); }
  std::size_t joint_count() const override { return std::size_t(framework_->joint_count()); }
  std::string instructions() const override { return newton_bars_instructions(); }
  std::string solver() const override { return "newton"; }

  void load(int lane, std::span<const Vec3> positions, const Breakage& breakage) override {
    Lane& it = lanes_[std::size_t(lane)];
    it.breakage = breakage;
    steps_of(lane).load(place_of(lane), positions, it.start,
                        int(std::min<long>(most_steps, settings_.max_iterations)));
  }

  void iterate() override {
    for (const auto& steps : steps_) steps->iterate();
  }

  bool done(int lane) const override {
    return steps_[std::size_t(lane) / width_]->state(place_of(lane)) != NewtonBars<T>::State::busy;
  }

  ResolveReport unload(int lane, std::span<Vec3> positions) override {
    const Lane& it = lanes_[std::size_t(lane)];
    ResolveReport report;
    if (conclude_steps(steps_of(lane), place_of(lane), it.start, positions, *framework_,
                       settings_.tolerance, settings_.max_iterations, report))
      return report;
    std::copy(it.start.begin(), it.start.end(), positions.begin());
    // what is rare is done by the resolver of one conformer, from where the lane was loaded
    if (!alone_) alone_ = make_newton_bars_resolver(framework_, settings_, plan_);
    return alone_->resolve(positions, it.breakage);
  }

 private:
  struct Lane {
    std::vector<Vec3> start;  ///< as loaded (njoint)
    Breakage breakage;
  };

  NewtonBars<T>& steps_of(int lane) { return *steps_[std::size_t(lane) / width_]; }
  int place_of(int lane) const { return int(std::size_t(lane) % width_); }

  std::shared_ptr<const Framework> framework_;
  ResolverSettings settings_;
  std::shared_ptr<const NewtonBarsPlan> plan_;
  std::vector<Steps<T>> steps_;
  std::size_t width_ = 0;  ///< lanes of one of these
  std::vector<Lane> lanes_;
  std::unique_ptr<Resolver> alone_;  ///< made when first needed
};

}  // namespace

std::shared_ptr<const NewtonBarsPlan> plan_newton_bars(const Framework& framework,
                                                       const ResolverSettings& settings) {
  return NewtonBarsPlan::make(framework, settings);
}

std::unique_ptr<Resolver> make_newton_bars_resolver(std::shared_ptr<const Framework> framework,
                                                    const ResolverSettings& settings,
                                                    std::shared_ptr<const NewtonBarsPlan> plan) {
  return std::make_unique<NewtonBarsResolver>(std::move(framework), settings, std::move(plan));
}

std::unique_ptr<EnsembleResolver> make_newton_bars_ensemble(
    std::shared_ptr<const Framework> framework, const ResolverSettings& settings,
    std::shared_ptr<const NewtonBarsPlan> plan, int lanes) {
  if (settings.precision == Precision::single) {
    Steps<float> singles = make_singles(plan, *framework, settings.tolerance, true);
    if (singles)
      return std::make_unique<NewtonBarsEnsemble<float>>(
          std::move(framework), settings, std::move(plan), std::move(singles), lanes);
  }
  auto doubles = std::make_unique<NewtonBars<double>>(plan, *framework, settings.tolerance, true);
  return std::make_unique<NewtonBarsEnsemble<double>>(std::move(framework), settings,
                                                      std::move(plan), std::move(doubles), lanes);
}

}  // namespace ragdoll
