// Motions: the kinds that make_motion knows, one file each. Private to core.

#pragma once
#include <memory>
#include <span>
#include <vector>

#include "ragdoll/motion.h"  // Motion, MotionSettings

namespace ragdoll {

/// What the motions of all walkers share.
struct MotionPlan {
  std::shared_ptr<const Framework> framework;
  std::vector<Vec3> start;  ///< nm (njoint)
  MotionSettings settings;

  int joint_count() const { return framework->joint_count(); }
  bool fixed(int joint) const { return framework->fixed()[std::size_t(joint)] != 0; }
};
using SharedPlan = std::shared_ptr<const MotionPlan>;

MotionFactory momentum_factory(SharedPlan plan);
MotionFactory hinge_factory(SharedPlan plan);
MotionFactory modes_factory(SharedPlan plan);
MotionFactory steer_factory(SharedPlan plan);
MotionFactory away_factory(SharedPlan plan);
MotionFactory thermal_factory(SharedPlan plan);

/// The random part of a motion: every joint that is not fixed, normal with the settings' size.
void add_noise(const MotionPlan& plan, std::span<Vec3> positions, Random& random);

/// Numbers of a state in turn, back into what they were; an Error where they are too few.
class StateReader {
 public:
  explicit StateReader(std::span<const double> state) : state_(state) {}
  double number();
  std::vector<Vec3> points(std::size_t count);
  void end() const;  ///< @throw Error where numbers are left

 private:
  std::span<const double> state_;
  std::size_t at_ = 0;
};

/// Appends points to a state.
void put(std::vector<double>& state, std::span<const Vec3> points);

}  // namespace ragdoll
