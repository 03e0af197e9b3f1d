// Modes: excursions along given directions, those of an elastic network say: out to the amplitude
// and back to the start, one way, then the other, then the next mode. A mode that constraints hold
// up turns back where it got to; that is its amplitude then. The way back is not along the mode but
// towards the start, so that what was left of it otherwise is made up for.

#include <algorithm>  // max, min
#include <cmath>      // sqrt

#include "motions.h"
#include "ragdoll/error.h"          // Error
#include "ragdoll/superposition.h"  // superposition

namespace ragdoll {
namespace {

/// Steps without a new farthest point after which a leg has come to its end.
constexpr int patience = 12;

/// A leg out ends also where the RMSD from the start is so many amplitudes.
constexpr double widest = 1.5;

/// A leg back ends so many steps from the start.
constexpr double home = 2;

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
    const RigidMove turn = superposition(plan_->shared->start, positions);
    if (outwards())
      go_out(positions, turn);
    else
      go_back(positions, turn);
    add_noise(*plan_->shared, positions, random);
  }

  void kept(std::span<const Vec3>, std::span<const Vec3> after) override {
    const MotionSettings& settings = plan_->shared->settings;
    const RigidMove turn = superposition(plan_->shared->start, after);
    const double rmsd = rmsd_of(after, turn);
    const double now = outwards() ? way() * along(after, turn) : -rmsd;
    if (!(now > farthest_)) return wait();
    farthest_ = now;
    waited_ = 0;
    const bool there =
        outwards() ? now >= settings.mode_amplitude || rmsd >= widest * settings.mode_amplitude
                   : rmsd <= home * settings.mode_step;
    if (there) turn_round(rmsd);
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

  double rmsd_of(std::span<const Vec3> positions, const RigidMove& turn) const {
    double squares = 0;
    for (std::size_t j = 0; j < positions.size(); ++j)
      squares += (positions[j] - turn(plan_->shared->start[j])).squaredNorm();
    return std::sqrt(squares / double(positions.size()));
  }

  void go_out(std::span<Vec3> positions, const RigidMove& turn) const {
    const double step = plan_->shared->settings.mode_step;
    // what the steps before this one lost is made up for
    const double asked = farthest_ + step - way() * along(positions, turn);
    const double part = way() * std::max(step, std::min(asked, most_at_once * step));
    const std::vector<Vec3>& mode = plan_->modes[index()];
    for (std::size_t j = 0; j < positions.size(); ++j)
      if (!plan_->shared->fixed(int(j))) positions[j] += part * (turn.rotation * mode[j]);
  }

  void go_back(std::span<Vec3> positions, const RigidMove& turn) const {
    const double rmsd = rmsd_of(positions, turn);
    const double share = std::min(1.0, plan_->shared->settings.mode_step / std::max(rmsd, 1e-9));
    for (std::size_t j = 0; j < positions.size(); ++j)
      if (!plan_->shared->fixed(int(j)))
        positions[j] += share * (turn(plan_->shared->start[j]) - positions[j]);
  }

  void wait() {
    // on the way back random moves alone keep it from the start
    if (++waited_ >= patience) turn_round(outwards() ? std::abs(farthest_) : 0);
  }

  /// @param rmsd  from the start
  void turn_round(double rmsd) {
    waited_ = 0;
    leg_ = 1 - leg_;
    farthest_ = leg_ == 1 ? -(rmsd + plan_->shared->settings.mode_amplitude) : 0;
    if (leg_ == 0) excursion_ = double((std::size_t(excursion_) + 1) % (2 * plan_->modes.size()));
  }

  std::shared_ptr<const ModesPlan> plan_;
  double excursion_;     ///< mode and way: 0 the first one forwards, 1 backwards, 2 the second one
  double leg_ = 0;       ///< 0 out, 1 back
  double farthest_ = 0;  ///< how far the leg got: along the mode, or less the RMSD, nm
  double waited_ = 0;    ///< steps since it got there
};

}  // namespace

MotionFactory modes_factory(SharedPlan shared) {
  auto modes = normalised(*shared);
  auto plan = std::make_shared<const ModesPlan>(ModesPlan{std::move(shared), std::move(modes)});
  return [plan](std::uint64_t seed) { return std::make_unique<Modes>(plan, seed); };
}

}  // namespace ragdoll
