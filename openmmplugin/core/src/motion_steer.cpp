// Steer: joints that the user pulls, by a vector or towards a point, in every step.

#include <cmath>

#include "motions.h"
#include "ragdoll/error.h"  // Error

namespace ragdoll {
namespace {

class Steer final : public Motion {
 public:
  explicit Steer(SharedPlan plan) : plan_(std::move(plan)) {}

  void move(std::span<Vec3> positions, Random& random) override {
    for (const Pull& pull : plan_->settings.pulls) {
      const Vec3 step = step_of(pull, positions);
      for (const int joint : pull.joints)
        if (!plan_->fixed(joint)) positions[std::size_t(joint)] += step;
    }
    add_noise(*plan_, positions, random);
  }

 private:
  static Vec3 step_of(const Pull& pull, std::span<const Vec3> positions) {
    if (!pull.towards_point) return pull.vector;
    Vec3 centroid = Vec3::Zero();
    for (const int joint : pull.joints) centroid += positions[std::size_t(joint)];
    const Vec3 way = pull.point - centroid / double(pull.joints.size());
    const double length = way.norm(), most = pull.vector.norm();
    return length > most ? Vec3(way * (most / length)) : way;
  }

  SharedPlan plan_;
};

}  // namespace

MotionFactory steer_factory(SharedPlan plan) {
  if (plan->settings.pulls.empty()) throw Error("steering needs a pull");
  for (const Pull& pull : plan->settings.pulls) {
    if (pull.joints.empty()) throw Error("a pull needs joints that it moves");
    if (!pull.vector.allFinite() || !pull.point.allFinite())
      throw Error("a pull's numbers must be finite");
  }
  return [plan = std::move(plan)](std::uint64_t) { return std::make_unique<Steer>(plan); };
}

}  // namespace ragdoll
