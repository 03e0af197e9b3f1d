#include "ring_break.h"

#include <Eigen/Eigenvalues>  // SelfAdjointEigenSolver
#include <algorithm>          // min, upper_bound
#include <cmath>              // cos, sin
#include <numbers>            // pi
#include <utility>            // move

#include "ring_torsions.h"  // torsion_of

namespace ragdoll {
namespace {

/// How far joints are shaken, drawn from these. nm
constexpr std::array<double, 3> sizes = {0.035, 0.06, 0.1};

/// Of the breaks of a large ring, those that open it; of its bonds, those that turn then.
constexpr double opened = 0.8, turned_least = 0.3;

}  // namespace

RingBreak::RingBreak(int atoms, std::vector<Link> links)
    : atoms_(atoms), links_(std::move(links)), around_(std::size_t(atoms)) {
  for (std::size_t k = 0; k < links_.size(); ++k) {
    if (links_[k].opens) open_.push_back(int(k));
    around_[std::size_t(links_[k].a)].push_back({links_[k].b, int(k)});
    around_[std::size_t(links_[k].b)].push_back({links_[k].a, int(k)});
  }
}

void RingBreak::apply(std::span<Vec3> positions, Random& random) const {
  if (!open_.empty() && random.uniform() < opened)
    turn(positions, random);
  else
    shake(positions, random);
}

void RingBreak::shake(std::span<Vec3> positions, Random& random) const {
  Vec3 centre = Vec3::Zero();
  for (const Vec3& x : positions) centre += x;
  centre /= double(atoms_);
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Vec3& x : positions) spread += (x - centre) * (x - centre).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
  const Vec3 normal = solver.eigenvectors().col(0);
  const double height = 2 * random.uniform() - 1, size = sizes[random.below(sizes.size())];
  std::array<double, 3> normals{};
  for (Vec3& x : positions) {
    x -= (1 - height) * normal.dot(x - centre) * normal;
    random.fill_normal(normals);
    x += size * Vec3(normals[0], normals[1], normals[2]);
  }
}

void RingBreak::turn(std::span<Vec3> positions, Random& random) const {
  const int cut = open_[random.below(open_.size())];
  const double share = turned_least + (1 - turned_least) * random.uniform();
  // depth first without the link that is cut: what lies beyond a bridge follows it in `found`
  const std::size_t n = std::size_t(atoms_);
  std::vector<int> found, number(n, -1), low(n), came_by(n, -1), end(n);
  struct Visit {
    int atom;
    std::size_t next;
  };
  const int start = links_[std::size_t(cut)].a;
  std::vector<Visit> path;
  const auto enter = [&](int atom, int by) {
    number[std::size_t(atom)] = low[std::size_t(atom)] = int(found.size());
    came_by[std::size_t(atom)] = by;
    found.push_back(atom);
    path.push_back({atom, 0});
  };
  enter(start, -1);
  while (!path.empty()) {
    const int atom = path.back().atom;
    const auto& around = around_[std::size_t(atom)];
    if (path.back().next < around.size()) {
      const auto [other, link] = around[path.back().next++];
      if (link == cut || link == came_by[std::size_t(atom)]) continue;
      if (number[std::size_t(other)] >= 0)
        low[std::size_t(atom)] = std::min(low[std::size_t(atom)], number[std::size_t(other)]);
      else
        enter(other, link);
      continue;
    }
    end[std::size_t(atom)] = int(found.size());
    path.pop_back();
    if (path.empty()) break;
    const int before = path.back().atom;
    low[std::size_t(before)] = std::min(low[std::size_t(before)], low[std::size_t(atom)]);
  }
  // from the far end, so that torsions are measured before their atoms turn along
  for (const int atom : found) {
    const int by = came_by[std::size_t(atom)];
    if (by < 0 || low[std::size_t(atom)] < number[std::size_t(atom)]) continue;
    const Link& link = links_[std::size_t(by)];
    if (!link.turns || random.uniform() > share) continue;
    const auto at = [&](int which) -> const Vec3& {
      return positions[std::size_t(link.torsion[std::size_t(which)])];
    };
    const double bin =
        double(std::upper_bound(link.share.begin(), link.share.end(), float(random.uniform())) -
               link.share.begin());
    const double wanted =
        2 * std::numbers::pi * (std::min(bin, bins - 1.0) + random.uniform()) / bins;
    const double by_angle = wanted - torsion_of(at(0), at(1), at(2), at(3));
    // atoms beyond `atom` turn; seen along the bond from the torsion's b to c that is forward where
    // they are at c's side
    const bool forward = link.torsion[2] == atom;
    const Vec3 pivot = positions[std::size_t(atom)];
    const Vec3 axis = (at(2) - at(1)).normalized();
    const Eigen::AngleAxisd rotation(forward ? by_angle : -by_angle, axis);
    const Eigen::Matrix3d matrix = rotation.toRotationMatrix();
    for (int k = number[std::size_t(atom)]; k < end[std::size_t(atom)]; ++k) {
      Vec3& x = positions[std::size_t(found[std::size_t(k)])];
      x = pivot + matrix * (x - pivot);
    }
  }
}

}  // namespace ragdoll
