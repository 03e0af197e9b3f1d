#include "ragdoll/superposition.h"

#include <Eigen/Eigenvalues>  // SelfAdjointEigenSolver
#include <algorithm>          // max
#include <cmath>              // sqrt

#include "ragdoll/error.h"  // Error

namespace ragdoll {
namespace {

/// What Horn's quaternions are made from.
struct Moments {
  Vec3 centre_a = Vec3::Zero(), centre_b = Vec3::Zero();
  Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
  double squares = 0, weight = 0;

  Moments(std::span<const Vec3> a, std::span<const Vec3> b, std::span<const double> weights) {
    if (a.empty() || a.size() != b.size())
      throw Error("an RMSD needs two sets of as many points, at least one");
    if (!weights.empty() && weights.size() != a.size())
      throw Error("a superposition needs one weight for each point");
    const auto weight_of = [&](std::size_t j) { return weights.empty() ? 1.0 : weights[j]; };
    for (std::size_t j = 0; j < a.size(); ++j) {
      centre_a += weight_of(j) * a[j];
      centre_b += weight_of(j) * b[j];
      weight += weight_of(j);
    }
    if (!(weight > 0)) throw Error("a superposition needs a point that has weight");
    centre_a /= weight;
    centre_b /= weight;
    for (std::size_t j = 0; j < a.size(); ++j) {
      const Vec3 u = a[j] - centre_a, v = b[j] - centre_b;
      products += weight_of(j) * u * v.transpose();
      squares += weight_of(j) * (u.squaredNorm() + v.squaredNorm());
    }
  }

  /// Horn's matrix: its largest eigenvalue is the best sum of u . R v over proper rotations R, its
  /// eigenvector the quaternion of the rotation that takes a to b.
  Eigen::Matrix4d key() const {
    const Eigen::Matrix3d& m = products;
    Eigen::Matrix4d key;
    key << m.trace(), m(1, 2) - m(2, 1), m(2, 0) - m(0, 2), m(0, 1) - m(1, 0), 0,
        m(0, 0) - m(1, 1) - m(2, 2), m(0, 1) + m(1, 0), m(2, 0) + m(0, 2), 0, 0,
        m(1, 1) - m(0, 0) - m(2, 2), m(1, 2) + m(2, 1), 0, 0, 0, m(2, 2) - m(0, 0) - m(1, 1);
    return key.transpose();
  }
};

}  // namespace

double superposed_rmsd(std::span<const Vec3> a, std::span<const Vec3> b) {
  const Moments moments(a, b, {});
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(moments.key(),
                                                              Eigen::EigenvaluesOnly);
  const double overlap = solver.eigenvalues()[3];
  return std::sqrt(std::max(0.0, moments.squares - 2 * overlap) / double(a.size()));
}

RigidMove superposition(std::span<const Vec3> a, std::span<const Vec3> b,
                        std::span<const double> weights) {
  const Moments moments(a, b, weights);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(moments.key());
  const Eigen::Vector4d best = solver.eigenvectors().col(3);
  RigidMove move;
  move.rotation = Eigen::Quaterniond(best[0], best[1], best[2], best[3]).toRotationMatrix();
  move.translation = moments.centre_b - move.rotation * moments.centre_a;
  return move;
}

std::vector<Vec3> chosen(std::span<const Vec3> points, std::span<const int> indices) {
  std::vector<Vec3> some;
  some.reserve(indices.size());
  for (const int index : indices) some.push_back(points[std::size_t(index)]);
  return some;
}

}  // namespace ragdoll
