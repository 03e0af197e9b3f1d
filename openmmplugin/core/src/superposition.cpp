#include "ragdoll/superposition.h"

#include <Eigen/Eigenvalues>  // SelfAdjointEigenSolver
#include <algorithm>          // max
#include <cmath>              // sqrt

#include "ragdoll/error.h"  // Error

namespace ragdoll {

double superposed_rmsd(std::span<const Vec3> a, std::span<const Vec3> b) {
  if (a.empty() || a.size() != b.size())
    throw Error("an RMSD needs two sets of as many points, at least one");
  Vec3 centre_a = Vec3::Zero(), centre_b = Vec3::Zero();
  for (const Vec3& point : a) centre_a += point;
  for (const Vec3& point : b) centre_b += point;
  centre_a /= double(a.size());
  centre_b /= double(b.size());

  Eigen::Matrix3d m = Eigen::Matrix3d::Zero();
  double squares = 0;
  for (std::size_t j = 0; j < a.size(); ++j) {
    const Vec3 u = a[j] - centre_a, v = b[j] - centre_b;
    m += u * v.transpose();
    squares += u.squaredNorm() + v.squaredNorm();
  }
  // Horn's matrix: its largest eigenvalue is the best sum of u . R v over proper rotations R
  Eigen::Matrix4d key;
  key << m.trace(), m(1, 2) - m(2, 1), m(2, 0) - m(0, 2), m(0, 1) - m(1, 0), 0,
      m(0, 0) - m(1, 1) - m(2, 2), m(0, 1) + m(1, 0), m(2, 0) + m(0, 2), 0, 0,
      m(1, 1) - m(0, 0) - m(2, 2), m(1, 2) + m(2, 1), 0, 0, 0, m(2, 2) - m(0, 0) - m(1, 1);
  const Eigen::Matrix4d lower = key.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(lower, Eigen::EigenvaluesOnly);
  const double overlap = solver.eigenvalues()[3];
  return std::sqrt(std::max(0.0, squares - 2 * overlap) / double(a.size()));
}

}  // namespace ragdoll
