// Hinges: rigid units turn about rotatable bonds. Small parts turn as wholes; where much hangs on
// both sides of a bond, what lies between it and a bond a little further on turns about the line
// between the two, as a crankshaft does, so that far ends stay.

#include <algorithm>  // max, min
#include <cmath>      // sqrt
#include <utility>

#include "motions.h"
#include "ragdoll/error.h"       // Error
#include "ragdoll/hinge_tree.h"  // HingeTree

namespace ragdoll {
namespace {

/// Parts of up to so many joints turn as wholes: side chains, and a few residues at an end.
constexpr int small_part = 60;

/// A crank is at most so many hinges long: six residues, with two hinges each.
constexpr int longest_crank = 12;

/// Joints [first, last) of the tree's list, less [gap_first, gap_last), about a line of two joints.
struct Turn {
  int first, last, gap_first, gap_last;
  int from, to;
};

struct HingePlan {
  SharedPlan shared;
  HingeTree tree;
  int turns;  ///< in one step
};

class HingeMotion final : public Motion {
 public:
  explicit HingeMotion(std::shared_ptr<const HingePlan> plan) : plan_(std::move(plan)) {}

  void move(std::span<Vec3> positions, Random& random) override {
    const std::uint64_t count = plan_->tree.hinges().size();
    for (int k = 0; k < plan_->turns; ++k) {
      const Hinge& hinge = plan_->tree.hinges()[random.below(count)];
      double normal = 0;
      random.fill_normal({&normal, 1});
      const std::uint64_t length = 1 + random.below(longest_crank);
      apply(turn_for(hinge, int(length)), normal * plan_->shared->settings.hinge_angle, positions);
    }
    add_noise(*plan_->shared, positions, random);
  }

 private:
  Turn turn_for(const Hinge& hinge, int length) const {
    const auto [first, last] = plan_->tree.component(hinge);
    const int beyond = hinge.size(), before = last - first - beyond;
    const Turn outer{hinge.first, hinge.last, hinge.last, hinge.last, hinge.inner, hinge.outer};
    const Turn inner{first, last, hinge.first, hinge.last, hinge.inner, hinge.outer};
    if (std::min(beyond, before) <= small_part) return beyond <= before ? outer : inner;
    const Hinge* start = &hinge;
    for (int k = 0; k < length && start->parent >= 0; ++k)
      start = &plan_->tree.hinges()[std::size_t(start->parent)];
    if (start == &hinge) return beyond <= before ? outer : inner;
    return {start->first, start->last, hinge.first, hinge.last, start->inner, hinge.outer};
  }

  void apply(const Turn& turn, double angle, std::span<Vec3> positions) const {
    const Vec3 origin = positions[std::size_t(turn.from)];
    const Vec3 line = positions[std::size_t(turn.to)] - origin;
    const double length = line.norm();
    if (!(length > 0)) return;
    const Vec3 axis = line / length;
    double squares = 0;
    int count = 0;
    for_joints(turn, [&](std::size_t joint) {
      squares += axis.cross(positions[joint] - origin).squaredNorm();
      ++count;
    });
    if (count == 0) return;
    // a turn that moves much of the structure far is a turn that is taken back
    const double lever = std::sqrt(squares / count);
    const double most = plan_->shared->settings.hinge_reach / std::max(lever, 1e-6);
    const Eigen::Matrix3d rotation =
        Eigen::AngleAxisd(std::clamp(angle, -most, most), axis).toRotationMatrix();
    for_joints(turn, [&](std::size_t joint) {
      if (!plan_->shared->fixed(int(joint)))
        positions[joint] = origin + rotation * (positions[joint] - origin);
    });
  }

  template <class Call>
  void for_joints(const Turn& turn, Call call) const {
    const std::vector<int>& joints = plan_->tree.joints();
    for (int k = turn.first; k < turn.gap_first; ++k) call(std::size_t(joints[std::size_t(k)]));
    for (int k = turn.gap_last; k < turn.last; ++k) call(std::size_t(joints[std::size_t(k)]));
  }

  std::shared_ptr<const HingePlan> plan_;
};

}  // namespace

MotionFactory hinge_factory(SharedPlan shared) {
  HingeTree tree(*shared->framework);
  if (tree.hinges().empty())
    throw Error("nothing turns: the molecule has no rotatable bond; choose another perturbation");
  const double share = shared->settings.hinge_share * double(tree.hinges().size());
  auto plan = std::make_shared<const HingePlan>(
      HingePlan{std::move(shared), std::move(tree), std::max(1, int(share + 0.5))});
  return [plan](std::uint64_t) { return std::make_unique<HingeMotion>(plan); };
}

}  // namespace ragdoll
