// Away: a walker keeps clear of where it was. Conformers that are far enough from all that it
// remembers are remembered themselves; each step has a part that leads away from them.

#include <algorithm>  // min
#include <cmath>      // exp, sqrt
#include <limits>     // numeric_limits
#include <numeric>    // iota

#include "motions.h"
#include "ragdoll/error.h"          // Error
#include "ragdoll/superposition.h"  // superposition, chosen

namespace ragdoll {
namespace {

/// Conformers remembered at most; then the oldest goes, the start excepted.
constexpr std::size_t most_visited = 400;

struct AwayPlan {
  SharedPlan shared;
  std::vector<int> sites;
  std::vector<int> site_of_joint;
};

class Away final : public Motion {
 public:
  explicit Away(std::shared_ptr<const AwayPlan> plan)
      : plan_(std::move(plan)), visited_{chosen(plan_->shared->start, plan_->sites)} {}

  void move(std::span<Vec3> positions, Random& random) override {
    std::vector<Vec3> push = push_at(chosen(positions, plan_->sites));
    for (std::size_t j = 0; j < positions.size(); ++j) {
      const int site = plan_->site_of_joint[j];
      if (site >= 0 && !plan_->shared->fixed(int(j))) positions[j] += push[std::size_t(site)];
    }
    add_noise(*plan_->shared, positions, random);
  }

  void kept(std::span<const Vec3>, std::span<const Vec3> after) override {
    std::vector<Vec3> here = chosen(after, plan_->sites);
    for (const std::vector<Vec3>& there : visited_)
      if (superposed_rmsd(there, here) < spacing()) return;
    if (visited_.size() == most_visited) visited_.erase(visited_.begin() + 1);
    visited_.push_back(std::move(here));
  }

  std::vector<double> state() const override {
    std::vector<double> state = {double(visited_.size())};
    for (const std::vector<Vec3>& there : visited_) put(state, there);
    return state;
  }
  void restore(std::span<const double> state) override {
    StateReader reader(state);
    const double count = reader.number();
    if (!(count >= 1) || count > double(most_visited))
      throw Error("the state is not one of this perturbation");
    visited_.clear();
    for (int k = 0; k < int(count); ++k) visited_.push_back(reader.points(plan_->sites.size()));
    reader.end();
  }

 private:
  double spacing() const { return plan_->shared->settings.away_spacing; }

  /// The displacement of each site, RMS as the settings say; 0 where there is no way away.
  std::vector<Vec3> push_at(const std::vector<Vec3>& here) const {
    std::vector<Vec3> push(here.size(), Vec3::Zero());
    const auto add = [&](const std::vector<Vec3>& there, const RigidMove& move, double weight) {
      for (std::size_t k = 0; k < here.size(); ++k) push[k] += weight * (here[k] - move(there[k]));
    };
    switch (plan_->shared->settings.away) {
      case AwayFrom::nearest: {
        const std::vector<Vec3>& there = nearest(here);
        add(there, superposition(there, here), 1);
        break;
      }
      case AwayFrom::centroid:
        for (const std::vector<Vec3>& there : visited_) add(there, superposition(there, here), 1);
        break;
      case AwayFrom::density:
        for (const std::vector<Vec3>& there : visited_) {
          const RigidMove move = superposition(there, here);
          double squares = 0;
          for (std::size_t k = 0; k < here.size(); ++k)
            squares += (here[k] - move(there[k])).squaredNorm();
          const double width = spacing() * spacing() * double(here.size());
          add(there, move, std::exp(-0.5 * squares / width));
        }
        break;
    }
    double squares = 0;
    for (const Vec3& part : push) squares += part.squaredNorm();
    const double rms = std::sqrt(squares / double(push.size()));
    // at the start, and where pushes cancel, rounding errors have no way to tell
    constexpr double nothing = 1e-6;
    const double scale = rms > nothing ? plan_->shared->settings.away_step / rms : 0;
    for (Vec3& part : push) part *= scale;
    return push;
  }

  const std::vector<Vec3>& nearest(const std::vector<Vec3>& here) const {
    double least = std::numeric_limits<double>::infinity();
    const std::vector<Vec3>* best = &visited_.front();
    for (const std::vector<Vec3>& there : visited_) {
      const double rmsd = superposed_rmsd(there, here);
      if (rmsd < least) {
        least = rmsd;
        best = &there;
      }
    }
    return *best;
  }

  std::shared_ptr<const AwayPlan> plan_;
  std::vector<std::vector<Vec3>> visited_;  ///< nm (nvisited, nsite)
};

}  // namespace

MotionFactory away_factory(SharedPlan shared) {
  AwayPlan plan{shared, shared->settings.sites, shared->settings.site_of_joint};
  const std::size_t joints = shared->start.size();
  if (plan.sites.empty()) {
    plan.sites.resize(joints);
    std::iota(plan.sites.begin(), plan.sites.end(), 0);
  }
  if (plan.site_of_joint.empty()) {
    plan.site_of_joint.assign(joints, -1);
    for (std::size_t k = 0; k < plan.sites.size(); ++k)
      plan.site_of_joint[std::size_t(plan.sites[k])] = int(k);
  }
  if (plan.site_of_joint.size() != joints)
    throw Error("there are " + std::to_string(plan.site_of_joint.size()) + " sites for " +
                std::to_string(joints) + " joints");
  for (const int site : plan.site_of_joint)
    if (site < -1 || site >= int(plan.sites.size()))
      throw Error("site " + std::to_string(site) + " is not one of the motion's");
  auto whole = std::make_shared<const AwayPlan>(std::move(plan));
  return [whole](std::uint64_t) { return std::make_unique<Away>(whole); };
}

}  // namespace ragdoll
