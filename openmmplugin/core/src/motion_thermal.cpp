// Thermal: normal modes swing as heat has them do, all at once, each about the start with its own
// frequency, which is the higher the stiffer the mode is, and a phase of its own. A walk of random
// steps would take as many of them as this takes steps squared to be somewhere else. What
// constraints made of a conformer beside that is kept in part.

#include <algorithm>  // any_of, max, min
#include <cmath>      // cos, sin, sqrt
#include <limits>     // numeric_limits
#include <numbers>    // pi
#include <numeric>    // iota

#include "motions.h"
#include "ragdoll/error.h"          // Error
#include "ragdoll/superposition.h"  // superposition

namespace ragdoll {
namespace {

/// Frequencies differ between walkers by up to this share, so that no two modes of one stiffness
/// keep step.
constexpr double spread = 0.1;

/// A step that is taken back is made in parts, of this share of the way at least.
constexpr double least_share = 1.0 / 16;

/// So much of a swing passes while a step is taken back: another way is tried then.
constexpr double waited = 0.5;

struct ThermalPlan {
  SharedPlan shared;
  Eigen::MatrixXf modes;            ///< displacements of one deviation, nm (3 njoint, nmode)
  std::vector<double> frequencies;  ///< rad/step (nmode)
  std::vector<std::uint8_t> still;  ///< no mode moves the joint: it moves at random (njoint)
  bool pinned = false;              ///< fixed joints say where the start is
};

/// Frequencies in proportion to the square root of the stiffness, such that the sites move by the
/// settings' step, RMS.
std::vector<double> frequencies_of(const MotionSettings& settings) {
  const std::vector<std::vector<Vec3>>& modes = settings.modes;
  std::vector<int> sites = settings.sites;
  if (sites.empty()) {
    sites.resize(modes.front().size());
    std::iota(sites.begin(), sites.end(), 0);
  }
  std::vector<double> frequencies, squares;
  for (const std::vector<Vec3>& mode : modes) {
    double all = 0, at_sites = 0;
    for (const Vec3& part : mode) all += part.squaredNorm();
    for (const int site : sites) at_sites += mode[std::size_t(site)].squaredNorm();
    if (!(all > 0) || !std::isfinite(all)) throw Error("a thermal mode moves nothing");
    frequencies.push_back(1 / std::sqrt(all));
    squares.push_back(at_sites / double(sites.size()));
  }
  const double highest = *std::max_element(frequencies.begin(), frequencies.end());
  for (double& frequency : frequencies) frequency *= std::numbers::pi / highest;
  const auto step_at = [&](double scale) {
    double square = 0;
    for (std::size_t k = 0; k < modes.size(); ++k)
      square += squares[k] * 2 * (1 - std::cos(scale * frequencies[k]));
    return std::sqrt(square);
  };
  double low = 0, high = 1;
  for (int round = 0; round < 50; ++round) {
    const double scale = (low + high) / 2;
    (step_at(scale) < settings.thermal_step ? low : high) = scale;
  }
  for (double& frequency : frequencies) frequency *= high;
  return frequencies;
}

ThermalPlan plan_of(SharedPlan shared) {
  const MotionSettings& settings = shared->settings;
  const std::vector<std::vector<Vec3>>& modes = settings.modes;
  const std::size_t joints = shared->start.size();
  if (modes.empty()) throw Error("a thermal motion needs one mode at least");
  if (!(settings.memory >= 0) || !(settings.memory <= 1))
    throw Error("the memory of thermal motion must be from 0 to 1");
  for (std::size_t k = 0; k < modes.size(); ++k)
    if (modes[k].size() != joints)
      throw Error("mode " + std::to_string(k + 1) + " moves " + std::to_string(modes[k].size()) +
                  " joints, but the framework has " + std::to_string(joints));
  ThermalPlan plan{shared, Eigen::MatrixXf(3 * Eigen::Index(joints), Eigen::Index(modes.size())),
                   frequencies_of(settings), std::vector<std::uint8_t>(joints, 1)};
  for (std::size_t k = 0; k < modes.size(); ++k)
    for (std::size_t j = 0; j < joints; ++j) {
      plan.modes.col(Eigen::Index(k)).segment<3>(3 * Eigen::Index(j)) = modes[k][j].cast<float>();
      if (!modes[k][j].isZero(0)) plan.still[j] = 0;
    }
  const std::vector<std::uint8_t>& fixed = shared->framework->fixed();
  plan.pinned = std::any_of(fixed.begin(), fixed.end(), [](std::uint8_t one) { return one != 0; });
  return plan;
}

class Thermal final : public Motion {
 public:
  Thermal(std::shared_ptr<const ThermalPlan> plan, std::uint64_t seed)
      : plan_(std::move(plan)), now_(Eigen::VectorXd::Zero(plan_->modes.cols())), next_(now_) {
    // of no step
    Random random(seed, RandomStream::perturbation, std::numeric_limits<std::uint64_t>::max());
    for (const double frequency : plan_->frequencies) {
      phases_.push_back(2 * std::numbers::pi * random.uniform());
      frequencies_.push_back(frequency * (1 + spread * (2 * random.uniform() - 1)));
    }
  }

  void move(std::span<Vec3> positions, Random& random) override {
    const MotionPlan& shared = *plan_->shared;
    const double memory = shared.settings.memory;
    for (Eigen::Index k = 0; k < now_.size(); ++k) {
      const std::size_t mode = std::size_t(k);
      const double there =
          std::numbers::sqrt2 * std::sin(frequencies_[mode] * (time_ + 1) + phases_[mode]);
      next_[k] = now_[k] + share_ * (there - now_[k]);
    }
    displacement_.noalias() = plan_->modes * (next_ - memory * now_).cast<float>();
    const RigidMove turn = plan_->pinned ? RigidMove{} : superposition(shared.start, positions);
    for (std::size_t j = 0; j < positions.size(); ++j) {
      if (shared.fixed(int(j)) || plan_->still[j]) continue;
      const Vec3 home = turn(shared.start[j]);
      const Vec3 part = displacement_.segment<3>(3 * Eigen::Index(j)).cast<double>();
      positions[j] = home + memory * (positions[j] - home) + turn.rotation * part;
    }
    add_noise(shared, positions, random);
  }

  void kept(std::span<const Vec3>, std::span<const Vec3>) override {
    now_ = next_;
    time_ += share_;
    share_ = std::min(1.0, 2 * share_);
  }

  void taken_back() override {
    time_ += waited;
    share_ = std::max(least_share, share_ / 2);
  }

  std::vector<double> state() const override {
    std::vector<double> state = {time_, share_};
    state.insert(state.end(), now_.begin(), now_.end());
    return state;
  }
  void restore(std::span<const double> state) override {
    StateReader reader(state);
    time_ = reader.number();
    share_ = reader.number();
    for (double& amplitude : now_) amplitude = reader.number();
    reader.end();
  }

 private:
  std::shared_ptr<const ThermalPlan> plan_;
  std::vector<double> phases_, frequencies_;  ///< rad, rad/step (nmode)
  Eigen::VectorXd now_, next_;    ///< amplitudes of where it is and of the trial, deviations
  Eigen::VectorXf displacement_;  ///< nm (3 njoint)
  double time_ = 0;               ///< steps
  double share_ = 1;              ///< of the way that the next step makes
};

}  // namespace

MotionFactory thermal_factory(SharedPlan shared) {
  auto plan = std::make_shared<const ThermalPlan>(plan_of(std::move(shared)));
  return [plan](std::uint64_t seed) { return std::make_unique<Thermal>(plan, seed); };
}

}  // namespace ragdoll
