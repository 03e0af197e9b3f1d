// Tests for core/src/superposition.cpp.

#include "ragdoll/superposition.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>  // Quaterniond
#include <Eigen/SVD>       // jacobiSvd
#include <cmath>           // sqrt

#include "examples.h"

namespace ragdoll {
namespace {

using namespace examples;

Eigen::Matrix3d random_rotation(Random& random) {
  Eigen::Quaterniond q(random.gaussian(), random.gaussian(), random.gaussian(), random.gaussian());
  return q.normalized().toRotationMatrix();
}

Positions moved(const Positions& x, const Eigen::Matrix3d& rotation, const Vec3& shift) {
  Positions result;
  for (const Vec3& point : x) result.emplace_back(rotation * point + shift);
  return result;
}

double plain_rmsd(const Positions& a, const Positions& b) {
  double squares = 0;
  for (std::size_t j = 0; j < a.size(); ++j) squares += (a[j] - b[j]).squaredNorm();
  return std::sqrt(squares / double(a.size()));
}

TEST(Superposition, RotationAndTranslationAreNoDeviation) {
  Random random(1, RandomStream::generate, 0);
  for (int round = 0; round < 50; ++round) {
    const Positions a = random_points(3 + round, 2, random);
    const Vec3 shift = 10 * random_vector(random);
    EXPECT_NEAR(superposed_rmsd(a, moved(a, random_rotation(random), shift)), 0, 1e-6);
  }
}

TEST(Superposition, DoesNotDependOnHowEitherSetLies) {
  Random random(2, RandomStream::generate, 0);
  for (int round = 0; round < 50; ++round) {
    const Positions a = random_points(20, 1, random), b = random_points(20, 1, random);
    const double rmsd = superposed_rmsd(a, b);
    EXPECT_NEAR(superposed_rmsd(b, a), rmsd, 1e-9);
    const Positions turned = moved(a, random_rotation(random), random_vector(random));
    EXPECT_NEAR(superposed_rmsd(turned, b), rmsd, 1e-9);
    EXPECT_NEAR(superposed_rmsd(b, turned), rmsd, 1e-9);
  }
}

TEST(Superposition, IsTheLeastOverAllRotations) {
  Random random(3, RandomStream::generate, 0);
  Positions a = random_points(6, 1, random), b = random_points(6, 1, random);
  for (Positions* set : {&a, &b}) {
    Vec3 centre = Vec3::Zero();
    for (const Vec3& point : *set) centre += point / 6;
    for (Vec3& point : *set) point -= centre;
  }
  const double least = superposed_rmsd(a, b);
  double found = plain_rmsd(a, b);
  for (int trial = 0; trial < 20000; ++trial) {
    const double rmsd = plain_rmsd(a, moved(b, random_rotation(random), Vec3::Zero()));
    ASSERT_GE(rmsd, least - 1e-12);
    found = std::min(found, rmsd);
  }
  EXPECT_NEAR(found, least, 0.02);
}

TEST(Superposition, KnownDeviations) {
  // a pair that is longer by 2 on either side deviates by 2
  EXPECT_NEAR(superposed_rmsd(Positions{{-1, 0, 0}, {1, 0, 0}}, Positions{{0, 3, 0}, {0, -3, 0}}),
              2, 1e-12);
  EXPECT_EQ(superposed_rmsd(Positions{{1, 2, 3}}, Positions{{7, 8, 9}}), 0);
}

TEST(Superposition, MirrorImageIsNotTheSame) {
  const Positions a = {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}};
  Positions mirrored = a;
  for (Vec3& point : mirrored) point[0] = -point[0];
  EXPECT_GT(superposed_rmsd(a, mirrored), 0.3);
  // the best rotation of a mirror image: the thinnest direction stays mirrored (Kabsch)
  Eigen::MatrixXd points(3, 4);
  for (int j = 0; j < 4; ++j) points.col(j) = a[std::size_t(j)];
  points.colwise() -= points.rowwise().mean().eval();
  const double thinnest = points.jacobiSvd().singularValues()[2];
  EXPECT_NEAR(superposed_rmsd(a, mirrored), 2 * thinnest / 2, 1e-9);
}

TEST(Superposition, FlatSetsAreTheirOwnMirrorImages) {
  const Positions a = {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {3, 3, 0}};
  Positions mirrored = a;
  for (Vec3& point : mirrored) point[0] = -point[0];
  EXPECT_NEAR(superposed_rmsd(a, mirrored), 0, 1e-7);
}

TEST(Superposition, EmptyOrUnequalSetsAreRefused) {
  EXPECT_NE(refusal_of([] { superposed_rmsd(Positions{}, Positions{}); }), "");
  EXPECT_NE(refusal_of([] { superposed_rmsd(Positions(2), Positions(3)); }), "");
}

TEST(Superposition, MoveBringsPointsOntoTheirImages) {
  Random random(5, RandomStream::generate, 0);
  for (int round = 0; round < 50; ++round) {
    const Positions a = random_points(4 + round, 2, random);
    const Eigen::Matrix3d rotation = random_rotation(random);
    const Vec3 shift = 10 * random_vector(random);
    Positions b = moved(a, rotation, shift);
    const RigidMove move = superposition(a, b);
    EXPECT_NEAR((move.rotation - rotation).norm(), 0, 1e-6);
    for (std::size_t j = 0; j < a.size(); ++j) EXPECT_NEAR((move(a[j]) - b[j]).norm(), 0, 1e-6);
    const RigidMove back = move.inverse();
    for (std::size_t j = 0; j < a.size(); ++j) EXPECT_NEAR((back(b[j]) - a[j]).norm(), 0, 1e-6);
    // a point without weight has no say
    std::vector<double> weights(a.size(), 1);
    weights[0] = 0;
    b[0] += Vec3(1, 2, 3);
    EXPECT_NEAR((superposition(a, b, weights).rotation - rotation).norm(), 0, 1e-6);
    EXPECT_NEAR(
        plain_rmsd(moved(a, superposition(a, b).rotation, superposition(a, b).translation), b),
        superposed_rmsd(a, b), 1e-9);
  }
}

}  // namespace
}  // namespace ragdoll
