// All constraints at once: a few Gauss-Seidel sweeps take out what is rough, Levenberg-Marquardt
// the rest. Its cost is that of factoring a sparse matrix, linear in the joints where the framework
// is long rather than bulky, as molecules are.

#include "resolver_newton.h"

#include <algorithm>  // min, max, clamp
#include <array>
#include <utility>  // move

#include "newton_rows.h"     // NewtonRows, Misfit
#include "ragdoll/random.h"  // Random

namespace ragdoll {
namespace {

constexpr int first_sweeps = 2;

/// mu, relative to the stiffness of a bar. Far from the solution a small one goes too far; near it
/// a large one holds back.
constexpr double first_mu = 1e-2, usual_mu = 1e-4, smallest_mu = 1e-8, largest_mu = 1e8;

/// Stagnation: so many steps that together did not take this share of the energy away.
constexpr int patience = 6;
constexpr double progress = 0.2;

/// How often the worst violations are shaken, in all and without success, by how much of the
/// bars' mean length, and which they are: those of this share of the largest.
constexpr int most_shakes = 100, most_failures = 8;
constexpr std::array<double, 3> shakes = {0.2, 0.1, 0.4};
constexpr double worst_share = 0.3, shaken_mu = 1e-3;

class NewtonResolver final : public Resolver {
 public:
  NewtonResolver(std::shared_ptr<const Framework> framework, const ResolverSettings& settings)
      : framework_(std::move(framework)), settings_(settings), rows_(framework_) {
    for (const Bar& bar : framework_->bars()) mean_length_ += bar.length;
    if (!framework_->bars().empty()) mean_length_ /= double(framework_->bars().size());
  }

  std::string solver() const override { return "newton"; }

  ResolveReport resolve(std::span<Vec3> positions, const Breakage& breakage) override {
    x_ = positions;
    box_ = breakage.box;
    report_ = {};
    if (!take_measure()) return finish(StopReason::not_finite);
    if (done()) return finish(StopReason::nothing_broken);
    best_.clear();
    StopReason reason = start();
    int failures = 0;
    for (int k = 0; reason == StopReason::stagnated && failures < most_failures; ++k) {
      failures = keep_best() ? 0 : failures + 1;
      if (k == most_shakes || !shake_worst(k)) break;
      reason = descend(shaken_mu);
    }
    if (reason == StopReason::stagnated || reason == StopReason::max_iterations) {
      keep_best();
      std::copy(best_.begin(), best_.end(), x_.begin());
    }
    return finish(reason);
  }

 private:
  bool done() const { return misfit_.residual <= settings_.tolerance.value(); }

  bool take_measure() {
    misfit_ = rows_.measure(x_, box_);
    return misfit_.finite();
  }

  /// @return false if the maximum is reached
  bool count_iteration() {
    if (report_.iterations == settings_.max_iterations) return false;
    ++report_.iterations;
    report_.bar_visits += std::int64_t(framework_->bars().size());
    return true;
  }

  StopReason start() {
    for (int k = 0; k < first_sweeps; ++k) {
      if (!count_iteration()) return StopReason::max_iterations;
      rows_.sweep(x_, box_, settings_.tolerance.value());
      if (!take_measure()) return StopReason::not_finite;
      if (done()) return StopReason::within_tolerance;
    }
    return descend(first_mu);
  }

  StopReason descend(double mu) {
    double marked_energy = misfit_.energy;
    int since_mark = 0;
    bool held_back = false;  // the step before was taken back
    while (true) {
      if (!count_iteration()) return StopReason::max_iterations;
      rows_.assemble(x_, box_, step_);
      right_ = step_;
      bool accepted = false;
      double gain = 0;
      if (rows_.matrix().factor(mu)) {
        rows_.matrix().solve(step_);
        const double predicted = predicted_gain(mu);
        // nowhere to go: no gradient worth the name
        if (!(predicted > 1e-13 * misfit_.energy)) return StopReason::stagnated;
        const Misfit trial = try_step();
        accepted = trial.finite() && trial.energy < misfit_.energy;
        if (accepted) {
          gain = (misfit_.energy - trial.energy) / predicted;
          misfit_ = trial;
          std::copy(trial_.begin(), trial_.end(), x_.begin());
          if (done()) return StopReason::within_tolerance;
        }
      }
      mu = next_mu(mu, accepted, gain, held_back);
      held_back = !accepted;
      if (mu > largest_mu) return StopReason::stagnated;
      if (misfit_.energy < (1 - progress) * marked_energy) {
        marked_energy = misfit_.energy;
        since_mark = 0;
      } else if (++since_mark == patience) {
        return StopReason::stagnated;
      }
    }
  }

  /// Of the energy, by the linear rows and mu's hold together.
  double predicted_gain(double mu) const {
    double sum = 0;
    for (std::size_t j = 0; j < x_.size(); ++j)
      sum += step_[j].dot(right_[j]) + mu * step_[j].squaredNorm();
    return 0.5 * sum;
  }

  Misfit try_step() {
    trial_.assign(x_.begin(), x_.end());
    for (std::size_t j = 0; j < trial_.size(); ++j)
      if (!framework_->fixed()[j]) trial_[j] += step_[j];
    return rows_.measure(trial_, box_);
  }

  double next_mu(double mu, bool accepted, double gain, bool held_back) const {
    if (!accepted) return mu * 10;
    if (gain < 0.25) return mu * 4;
    if (gain < 0.5) return mu;
    // once all is nearly whole, a small mu makes the last digits come by the square
    const double floor = misfit_.residual > 1e-3 ? usual_mu : smallest_mu;
    return std::max(floor, mu / (held_back ? 2 : 10));
  }

  // === Stagnation

  /// The positions of the smallest energy so far. @return true if it is notably smaller now
  bool keep_best() {
    if (!best_.empty() && best_energy_ <= misfit_.energy) return false;
    const bool better = best_.empty() || misfit_.energy < 0.99 * best_energy_;
    best_.assign(x_.begin(), x_.end());
    best_energy_ = misfit_.energy;
    return better;
  }

  /// Starts from the best positions, with the joints of the worst violations moved at random:
  /// mostly one group that is caught in its mirror image. @return false if none of them can move
  bool shake_worst(int round) {
    std::copy(best_.begin(), best_.end(), x_.begin());
    if (!take_measure()) return false;
    const double limit = std::max(settings_.tolerance.value(), worst_share * misfit_.residual);
    const std::vector<int> joints = rows_.violated_joints(x_, box_, limit);
    Random random(0, RandomStream::order, std::uint64_t(round));
    const double size = mean_length_ * shakes[std::size_t(round) % shakes.size()];
    for (const int joint : joints) {
      Vec3& point = x_[std::size_t(joint)];
      for (int i = 0; i < 3; ++i) point[i] += size * (2 * random.uniform() - 1);
    }
    return !joints.empty() && take_measure();
  }

  ResolveReport finish(StopReason reason) {
    report_.reason = reason;
    report_.converged =
        reason == StopReason::nothing_broken || reason == StopReason::within_tolerance;
    if (report_.converged) {
      report_.residual = misfit_.residual;
    } else {
      const Violation worst = worst_violation(*framework_, x_, box_);
      report_.residual = worst.relative;
      report_.worst = worst.what;
    }
    return report_;
  }

  std::shared_ptr<const Framework> framework_;
  ResolverSettings settings_;
  NewtonRows rows_;
  double mean_length_ = 0;  ///< of the bars, nm

  // the break at hand
  std::span<Vec3> x_;
  const Box* box_ = nullptr;
  ResolveReport report_;
  Misfit misfit_;  ///< of x_
  std::vector<Vec3> step_, right_, trial_, best_;
  double best_energy_ = 0;
};

}  // namespace

std::unique_ptr<Resolver> make_newton_resolver(std::shared_ptr<const Framework> framework,
                                               const ResolverSettings& settings) {
  return std::make_unique<NewtonResolver>(std::move(framework), settings);
}

}  // namespace ragdoll
