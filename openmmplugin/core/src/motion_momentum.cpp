// Momentum: the step that was kept last is made again, times a factor, beside a random part
// (FRODAN: Farrell, Speranskiy and Thorpe, Proteins 78, 2908, 2010). What the walker drifted and
// turned as a whole is not part of it.

#include <algorithm>  // any_of
#include <cmath>      // sqrt

#include "motions.h"
#include "ragdoll/superposition.h"  // superposition

namespace ragdoll {
namespace {

/// A step that is made again is at most this many sizes of the random part long, RMS: constraints
/// turn random moves into slower ones, so that only a run away from all of them gets there.
constexpr double fastest = 10;

/// What is left of the momentum when a step was taken back: it ran into something.
constexpr double after_a_stop = 0.5;

class Momentum final : public Motion {
 public:
  explicit Momentum(SharedPlan plan)
      : plan_(std::move(plan)),
        last_(plan_->start.size(), Vec3::Zero()),
        pinned_(std::any_of(plan_->framework->fixed().begin(), plan_->framework->fixed().end(),
                            [](std::uint8_t fixed) { return fixed != 0; })) {}

  void move(std::span<Vec3> positions, Random& random) override {
    const double share = plan_->settings.persistence;
    for (std::size_t j = 0; j < positions.size(); ++j)
      if (!plan_->fixed(int(j))) positions[j] += share * last_[j];
    add_noise(*plan_, positions, random);
  }

  void kept(std::span<const Vec3> before, std::span<const Vec3> after) override {
    const RigidMove back = pinned_ ? RigidMove{} : superposition(after, before);
    double squares = 0;
    for (std::size_t j = 0; j < last_.size(); ++j) {
      last_[j] = back(after[j]) - before[j];
      squares += last_[j].squaredNorm();
    }
    const double rms = std::sqrt(squares / double(last_.size()));
    const double most = fastest * plan_->settings.size;
    if (rms > most) scale(most / rms);
  }

  void taken_back() override { scale(after_a_stop); }

  std::vector<double> state() const override {
    std::vector<double> state;
    put(state, last_);
    return state;
  }
  void restore(std::span<const double> state) override {
    StateReader reader(state);
    last_ = reader.points(last_.size());
    reader.end();
  }

 private:
  void scale(double factor) {
    for (Vec3& step : last_) step *= factor;
  }

  SharedPlan plan_;
  std::vector<Vec3> last_;  ///< the last step that was kept, nm (njoint)
  bool pinned_;             ///< fixed joints keep it from drifting
};

}  // namespace

MotionFactory momentum_factory(SharedPlan plan) {
  return [plan = std::move(plan)](std::uint64_t) { return std::make_unique<Momentum>(plan); };
}

}  // namespace ragdoll
