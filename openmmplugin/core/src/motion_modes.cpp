// Modes: excursions along given directions, those of an elastic network say: out to the amplitude
// and back, one way, then the other, then the next mode. A mode that constraints hold up turns back
// where it got to; that is its amplitude then.

#include <algorithm>  // clamp
#include <cmath>      // sqrt

#include "motions.h"
#include "ragdoll/error.h"          // Error
#include "ragdoll/superposition.h"  // superposition

namespace ragdoll {
namespace {

/// Steps without a new farthest point after which a leg has come to its end.
constexpr int patience = 12;

/// A step is asked to make up for what the steps before it lost, but for no more than this many.
constexpr double most_at_once = 2;

struct ModesPlan {
  SharedPlan shared;
  std::vector<std::vector<Vec3>> modes;  ///< RMS 1 (nmode, njoint)
};

std::vector<std::vector<Vec3>> normalised(const MotionPlan& plan) {
  std::vector<std::vector<Vec3>> modes = plan.settings.modes;
  if (modes.empty()) throw Error("a motion along modes needs one mode at least");
  for (std::size_t k = 0; k < modes.size(); ++k) {
    if (int(modes[k].size()) != plan.joint_count())
      throw Error("mode " + std::to_string(k + 1) + " moves " + std::to_string(modes[k].size()) +
                  " joints, but the framework has " + std::to_string(plan.joint_count()));
    double squares = 0;
    for (const Vec3& part : modes[k]) squares += part.squaredNorm();
    if (!(squares > 0) || !std::isfinite(squares))
      throw Error("mode " + std::to_string(k + 1) + " moves nothing, or is not finite");
    const double scale = std::sqrt(double(modes[k].size()) / squares);
    for (Vec3& part : modes[k]) part *= scale;
  }
  return modes;
}

class Modes final : public Motion {
 public:
  Modes(std::shared_ptr<const ModesPlan> plan, std::uint64_t seed)
      : plan_(std::move(plan)), excursion_(double(seed % (2 * plan_->modes.size()))) {}

  void move(std::span<Vec3> positions, Random& random) override {
    const MotionSettings& settings = plan_->shared->settings;
    const RigidMove turn = superposition(plan_->shared->start, positions);
    const double now = along(positions, turn);
    const double asked = outwards() ? way() * (farthest_ + settings.mode_step)
                                    : way() * (farthest_ - settings.mode_step);
    const double most = most_at_once * settings.mode_step;
    const double step = std::clamp(asked - now, -most, most);
    const std::vector<Vec3>& mode = plan_->modes[index()];
    for (std::size_t j = 0; j < positions.size(); ++j)
      if (!plan_->shared->fixed(int(j))) positions[j] += step * (turn.rotation * mode[j]);
    add_noise(*plan_->shared, positions, random);
  }

  void kept(std::span<const Vec3>, std::span<const Vec3> after) override {
    const RigidMove turn = superposition(plan_->shared->start, after);
    const double now = way() * along(after, turn);
    const bool gained = outwards() ? now > farthest_ : now < farthest_;
    if (!gained) return wait();
    farthest_ = now;
    waited_ = 0;
    if (outwards() ? now >= plan_->shared->settings.mode_amplitude : now <= 0) turn_round();
  }

  void taken_back() override { wait(); }

  std::vector<double> state() const override { return {excursion_, leg_, farthest_, waited_}; }
  void restore(std::span<const double> state) override {
    StateReader reader(state);
    excursion_ = reader.number();
    leg_ = reader.number();
    farthest_ = reader.number();
    waited_ = reader.number();
    reader.end();
    if (!(excursion_ >= 0) || excursion_ >= 2.0 * double(plan_->modes.size()))
      throw Error("the state is not one of these modes");
  }

 private:
  std::size_t index() const { return std::size_t(excursion_) / 2; }
  double way() const { return std::size_t(excursion_) % 2 == 0 ? 1 : -1; }
  bool outwards() const { return leg_ == 0; }

  /// RMSD from the start along the mode, with its sign. nm
  double along(std::span<const Vec3> positions, const RigidMove& turn) const {
    const std::vector<Vec3>& mode = plan_->modes[index()];
    double sum = 0;
    for (std::size_t j = 0; j < positions.size(); ++j)
      sum += (positions[j] - turn(plan_->shared->start[j])).dot(turn.rotation * mode[j]);
    return sum / double(positions.size());
  }

  void wait() {
    if (++waited_ >= patience) turn_round();
  }

  void turn_round() {
    waited_ = 0;
    leg_ = 1 - leg_;
    if (leg_ == 1) return;
    excursion_ = double((std::size_t(excursion_) + 1) % (2 * plan_->modes.size()));
    farthest_ = 0;
  }

  std::shared_ptr<const ModesPlan> plan_;
  double excursion_;     ///< mode and way: 0 the first one forwards, 1 backwards, 2 the second one
  double leg_ = 0;       ///< 0 out, 1 back
  double farthest_ = 0;  ///< where the leg is, nm
  double waited_ = 0;    ///< steps since it got there
};

}  // namespace

MotionFactory modes_factory(SharedPlan shared) {
  auto modes = normalised(*shared);
  auto plan = std::make_shared<const ModesPlan>(ModesPlan{std::move(shared), std::move(modes)});
  return [plan](std::uint64_t seed) { return std::make_unique<Modes>(plan, seed); };
}

}  // namespace ragdoll
