#include "ragdoll/rigid_units.h"

#include <Eigen/Eigenvalues>  // SelfAdjointEigenSolver
#include <algorithm>          // max, sort, lower_bound, find
#include <array>
#include <cmath>    // sqrt, isfinite
#include <numeric>  // iota
#include <utility>  // pair, move

namespace ragdoll {
namespace {

/// Bars by their joints.
class Lengths {
 public:
  explicit Lengths(const Framework& framework) : partners_(framework.masses().size()) {
    for (int k = 0; k < int(framework.bars().size()); ++k) {
      const Bar& bar = framework.bars()[std::size_t(k)];
      partners_[std::size_t(bar.p)].push_back({bar.q, k});
      partners_[std::size_t(bar.q)].push_back({bar.p, k});
    }
    for (auto& list : partners_) std::sort(list.begin(), list.end());
  }

  const std::vector<std::pair<int, int>>& of(int joint) const {
    return partners_[std::size_t(joint)];
  }

  /// The bar between two joints, or -1.
  int bar(int p, int q) const {
    const auto& list = of(p);
    const auto found = std::lower_bound(list.begin(), list.end(), std::pair(q, -1));
    return found != list.end() && found->first == q ? found->second : -1;
  }

 private:
  std::vector<std::vector<std::pair<int, int>>> partners_;  ///< (joint, bar), ascending
};

class UnitFinder {
 public:
  UnitFinder(const Framework& framework, int largest)
      : framework_(framework),
        lengths_(framework),
        largest_(largest),
        held_(framework.bars().size()),
        volumes_of_(framework.masses().size()) {
    for (std::size_t k = 0; k < framework.volumes().size(); ++k)
      volumes_of_[std::size_t(framework.volumes()[k].a)].push_back(int(k));
  }

  std::vector<RigidUnit> find() {
    std::vector<RigidUnit> units;
    // bars across angles and planes first: they lead to the largest units
    std::vector<int> bars(framework_.bars().size());
    std::iota(bars.begin(), bars.end(), 0);
    const auto rank = [&](int bar) {
      const BarKind kind = framework_.bars()[std::size_t(bar)].kind;
      return kind == BarKind::planar ? 0 : kind == BarKind::angle ? 1 : 2;
    };
    std::stable_sort(bars.begin(), bars.end(), [&](int a, int b) { return rank(a) < rank(b); });
    for (const int bar : bars) {
      if (held_[std::size_t(bar)]) continue;
      RigidUnit unit;
      unit.joints = grow(framework_.bars()[std::size_t(bar)]);
      hold(unit.joints);
      give_shape(unit);
      units.push_back(std::move(unit));
    }
    return units;
  }

 private:
  /// Joints that are barred to each other, the bar's own among them. Of those that may join, the
  /// one with the most bars to the others comes first.
  std::vector<int> grow(const Bar& bar) const {
    std::vector<int> unit = {bar.p, bar.q}, open;
    for (const auto& [joint, k] : lengths_.of(bar.p))
      if (joint != bar.q && lengths_.bar(joint, bar.q) >= 0) open.push_back(joint);
    while (!open.empty() && int(unit.size()) < largest_) {
      int best = -1, most = -1;
      for (const int joint : open) {
        int count = 0;
        for (const int other : open) count += other != joint && lengths_.bar(joint, other) >= 0;
        if (count > most) {
          most = count;
          best = joint;
        }
      }
      unit.push_back(best);
      std::erase_if(open,
                    [&](int joint) { return joint == best || lengths_.bar(joint, best) < 0; });
    }
    std::sort(unit.begin(), unit.end());
    return unit;
  }

  void hold(const std::vector<int>& joints) {
    for (std::size_t i = 0; i < joints.size(); ++i)
      for (std::size_t j = i + 1; j < joints.size(); ++j)
        held_[std::size_t(lengths_.bar(joints[i], joints[j]))] = true;
  }

  /// Places by classical scaling: the three largest eigenvectors of the centred squares of the
  /// distances.
  void give_shape(RigidUnit& unit) const {
    const Eigen::Index n = Eigen::Index(unit.joints.size());
    if (n == 2) {
      const double half = length(unit.joints[0], unit.joints[1]) / 2;
      unit.shape = {Vec3(-half, 0, 0), Vec3(half, 0, 0)};
      return;
    }
    Eigen::MatrixXd squares = Eigen::MatrixXd::Zero(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = i + 1; j < n; ++j) {
        const double d = length(unit.joints[std::size_t(i)], unit.joints[std::size_t(j)]);
        squares(i, j) = squares(j, i) = d * d;
      }
    const Eigen::VectorXd means = squares.rowwise().mean();
    const double mean = means.mean();
    Eigen::MatrixXd gram = squares;
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j)
        gram(i, j) = -(squares(i, j) - means[i] - means[j] + mean) / 2;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(gram);
    unit.shape.assign(std::size_t(n), Vec3::Zero());
    double thickness = 0, width = 0;
    for (Eigen::Index k = 0; k < 3; ++k) {
      const double value = std::max(0.0, solver.eigenvalues()[n - 1 - k]);
      if (k == 0) width = value;
      if (k == 2) thickness = value;
      for (Eigen::Index i = 0; i < n; ++i)
        unit.shape[std::size_t(i)][k] = solver.eigenvectors()(i, n - 1 - k) * std::sqrt(value);
    }
    if (thickness < flat * width) return;
    const int hand = hand_of(unit);
    unit.either_hand = hand == 0;
    if (hand < 0)
      for (Vec3& point : unit.shape) point[2] = -point[2];
  }

  /// 1 where the shape has the hand that volumes ask for, -1 where its mirror image has, 0 where
  /// none asks.
  int hand_of(const RigidUnit& unit) const {
    const auto place = [&](int joint) {
      const auto found = std::lower_bound(unit.joints.begin(), unit.joints.end(), joint);
      return found != unit.joints.end() && *found == joint ? int(found - unit.joints.begin()) : -1;
    };
    for (const int joint : unit.joints)
      for (const int k : volumes_of_[std::size_t(joint)]) {
        const Volume& v = framework_.volumes()[std::size_t(k)];
        // one that may be of either sign asks for nothing
        if (!(v.lower > 0) && !(v.upper < 0)) continue;
        const std::array<int, 4> at = {place(v.a), place(v.b), place(v.c), place(v.d)};
        if (std::find(at.begin(), at.end(), -1) != at.end()) continue;
        const auto x = [&](int i) -> const Vec3& {
          return unit.shape[std::size_t(at[std::size_t(i)])];
        };
        const double volume = signed_volume(x(0), x(1), x(2), x(3));
        return (volume > 0) == (v.lower > 0) ? 1 : -1;
      }
    return 0;
  }

  double length(int p, int q) const {
    return framework_.bars()[std::size_t(lengths_.bar(p, q))].length;
  }

  static constexpr double flat = 1e-6;  ///< of the shape's squares, across and along
  const Framework& framework_;
  Lengths lengths_;
  int largest_;
  std::vector<bool> held_;                    ///< whether a unit holds the bar (nbar)
  std::vector<std::vector<int>> volumes_of_;  ///< by their first joint
};

}  // namespace

std::vector<RigidUnit> find_rigid_units(const Framework& framework, int largest) {
  return UnitFinder(framework, largest).find();
}

}  // namespace ragdoll
