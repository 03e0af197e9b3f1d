#include "ragdoll/motion.h"

#include <array>
#include <cmath>    // isfinite
#include <utility>  // move

#include "motions.h"        // MotionPlan, factories
#include "names.h"          // value_of
#include "ragdoll/error.h"  // Error

namespace ragdoll {
namespace {

constexpr std::array<std::pair<MotionKind, const char*>, 8> kinds = {{
    {MotionKind::gaussian, "gaussian"},
    {MotionKind::ball, "ball"},
    {MotionKind::momentum, "momentum"},
    {MotionKind::hinge, "hinge"},
    {MotionKind::modes, "modes"},
    {MotionKind::steer, "steer"},
    {MotionKind::away, "away"},
    {MotionKind::thermal, "thermal"},
}};

constexpr std::array<std::pair<AwayFrom, const char*>, 3> away_names = {{
    {AwayFrom::nearest, "nearest"},
    {AwayFrom::centroid, "centroid"},
    {AwayFrom::density, "density"},
}};

/// FRODA's, without a memory.
class RandomMotion final : public Motion {
 public:
  RandomMotion(SharedPlan plan, PerturbationKind kind) : plan_(std::move(plan)), kind_(kind) {}
  void move(std::span<Vec3> positions, Random& random) override {
    perturb(positions, plan_->framework->fixed(), kind_, plan_->settings.size, random);
  }

 private:
  SharedPlan plan_;
  PerturbationKind kind_;
};

MotionFactory random_factory(SharedPlan plan, PerturbationKind kind) {
  return [plan = std::move(plan), kind](std::uint64_t) {
    return std::make_unique<RandomMotion>(plan, kind);
  };
}

void check_number(double value, const char* what) {
  if (!(value >= 0) || !std::isfinite(value))
    throw Error(std::string(what) + " must be a number, 0 or more");
}

void check_joint(const Framework& framework, int joint) {
  if (joint < 0 || joint >= framework.joint_count())
    throw Error("joint " + std::to_string(joint) + " of the motion is no joint; there are " +
                std::to_string(framework.joint_count()));
}

void check(const MotionPlan& plan) {
  const MotionSettings& s = plan.settings;
  if (int(plan.start.size()) != plan.joint_count())
    throw Error("there are " + std::to_string(plan.start.size()) + " positions for " +
                std::to_string(plan.joint_count()) + " joints");
  if (!(s.size >= 0) || !std::isfinite(s.size))
    throw Error("the size of the perturbation must be 0 nm or more");
  if (!(s.persistence >= 0) || !(s.persistence <= 1))
    throw Error("the persistence of the momentum must be from 0 to 1");
  check_number(s.hinge_angle, "the angle of hinges");
  check_number(s.hinge_reach, "the reach of hinges");
  if (!(s.hinge_share > 0) || !(s.hinge_share <= 1))
    throw Error("the share of the hinges that turn must be above 0 and at most 1");
  check_number(s.mode_amplitude, "the amplitude of modes");
  check_number(s.mode_step, "the step along modes");
  check_number(s.away_step, "the step away");
  check_number(s.thermal_step, "the step of thermal motion");
  if (!(s.away_spacing > 0)) throw Error("the spacing of visited conformers must be above 0");
  for (const Pull& pull : s.pulls)
    for (const int joint : pull.joints) check_joint(*plan.framework, joint);
  for (const int joint : s.sites) check_joint(*plan.framework, joint);
}

}  // namespace

MotionKind motion_kind(const std::string& name) {
  return value_of(kinds, name, "perturbation");
}
std::string name_of(MotionKind kind) {
  return name_in(kinds, kind);
}
std::vector<std::string> motion_names() {
  std::vector<std::string> names;
  for (const auto& [kind, name] : kinds) names.emplace_back(name);
  return names;
}
AwayFrom away_from(const std::string& name) {
  return value_of(away_names, name, "way of keeping away");
}
std::string name_of(AwayFrom from) {
  return name_in(away_names, from);
}

void Motion::restore(std::span<const double> state) {
  StateReader(state).end();
}

MotionFactory motion_factory(std::shared_ptr<const Framework> framework,
                             std::span<const Vec3> start, const MotionSettings& settings) {
  auto plan = std::make_shared<const MotionPlan>(
      MotionPlan{std::move(framework), {start.begin(), start.end()}, settings});
  check(*plan);
  switch (settings.kind) {
    case MotionKind::gaussian:
      return random_factory(plan, PerturbationKind::gaussian);
    case MotionKind::ball:
      return random_factory(plan, PerturbationKind::ball);
    case MotionKind::momentum:
      return momentum_factory(plan);
    case MotionKind::hinge:
      return hinge_factory(plan);
    case MotionKind::modes:
      return modes_factory(plan);
    case MotionKind::steer:
      return steer_factory(plan);
    case MotionKind::away:
      return away_factory(plan);
    case MotionKind::thermal:
      return thermal_factory(plan);
  }
  throw Error("the kind of motion is not known");
}

void add_noise(const MotionPlan& plan, std::span<Vec3> positions, Random& random) {
  perturb(positions, plan.framework->fixed(), PerturbationKind::gaussian, plan.settings.size,
          random);
}

double StateReader::number() {
  if (at_ == state_.size())
    throw Error("the state is not one of this perturbation: it is too short");
  return state_[at_++];
}

std::vector<Vec3> StateReader::points(std::size_t count) {
  std::vector<Vec3> points(count);
  for (Vec3& point : points)
    for (int axis = 0; axis < 3; ++axis) point[axis] = number();
  return points;
}

void StateReader::end() const {
  if (at_ != state_.size())
    throw Error("the state is not one of this perturbation: it is too long");
}

void put(std::vector<double>& state, std::span<const Vec3> points) {
  for (const Vec3& point : points) state.insert(state.end(), {point[0], point[1], point[2]});
}

}  // namespace ragdoll
