// Tests for core/src/break.cpp.

#include "ragdoll/break.h"

#include <gtest/gtest.h>

#include <cmath>  // pow

#include "examples.h"

namespace ragdoll {
namespace {

using namespace examples;

using Flags = std::vector<std::uint8_t>;

Random dice(std::uint64_t step = 0) {
  return Random(1, RandomStream::perturbation, step);
}

/// Displacements of `count` joints from the origin.
Positions displacements(int count, PerturbationKind kind, double size, Random random) {
  Positions x(std::size_t(count), Vec3::Zero());
  perturb(x, Flags(std::size_t(count), 0), kind, size, random);
  return x;
}

// === Verlet

TEST(Verlet, MovesOnlyTheAffectedJointByItsForce) {
  Positions x = {{1, 2, 3}, {4, 5, 6}};
  const Positions before = x, previous = {{1, 2, 3}, {4, 5, 5}}, forces = {{0, 8, 0}, {0, 0, 0}};
  verlet(x, previous, forces, std::vector<double>{2, 2}, Flags{0, 0}, 0.5, VerletScope::affected);
  EXPECT_EQ(x[0], Vec3(1, 3, 3));  // F/m dt^2 = 8/2 * 0.25
  EXPECT_EQ(x[1], before[1]);      // though it has a velocity
}

TEST(Verlet, AffectedJointKeepsItsVelocityToo) {
  Positions x = {{1, 0, 0}};
  verlet(x, Positions{{0.75, 0, 0}}, Positions{{0, 4, 0}}, std::vector<double>{1}, Flags{0}, 0.5,
         VerletScope::affected);
  EXPECT_EQ(x[0], Vec3(1.25, 1, 0));
}

TEST(Verlet, ScopeAllMovesEveryJointWithItsInferredVelocity) {
  Positions x = {{1, 2, 3}, {4, 5, 6}};
  const Positions previous = {{1, 2, 3}, {4, 5, 5.5}}, forces = {{0, 8, 0}, {0, 0, 0}};
  verlet(x, previous, forces, std::vector<double>{2, 2}, Flags{0, 0}, 0.5, VerletScope::all);
  EXPECT_EQ(x[0], Vec3(1, 3, 3));
  EXPECT_EQ(x[1], Vec3(4, 5, 6.5));
}

TEST(Verlet, ConstantForceFollowsTheClosedForm) {
  // at rest: after n steps the sum of 1..n steps of a dt^2
  for (const VerletScope scope : {VerletScope::affected, VerletScope::all}) {
    const double dt = 0.01, mass = 3;
    const Vec3 force(6, -3, 1.5);
    Positions x = {Vec3::Zero()}, previous = x;
    for (int n = 1; n <= 100; ++n) {
      const Positions current = x;
      verlet(x, previous, Positions{force}, std::vector<double>{mass}, Flags{0}, dt, scope);
      previous = current;
      const Vec3 expected = force / mass * dt * dt * n * (n + 1) / 2;
      EXPECT_NEAR((x[0] - expected).norm(), 0, 1e-12 * n * n);
    }
  }
}

TEST(Verlet, MotionWithoutForceIsUniform) {
  Positions x = {{1, 1, 1}}, previous = {{0.5, 1, 1.25}};
  for (int n = 0; n < 10; ++n) {
    const Positions current = x;
    verlet(x, previous, Positions{Vec3::Zero()}, std::vector<double>{1}, Flags{0}, 1,
           VerletScope::all);
    previous = current;
  }
  EXPECT_EQ(x[0], Vec3(6, 1, -1.5));
}

TEST(Verlet, MotionIsReversible) {
  Random random = dice();
  const Positions start = random_points(5, 1, random), next = random_points(5, 1, random);
  const Positions forces = random_points(5, 10, random);
  Positions x = next, previous = start;
  const auto step = [&] {
    const Positions current = x;
    verlet(x, previous, forces, std::vector<double>(5, 2), Flags(5, 0), 0.1, VerletScope::all);
    previous = current;
  };
  for (int n = 0; n < 50; ++n) step();
  std::swap(x, previous);
  for (int n = 0; n < 50; ++n) step();
  for (std::size_t j = 0; j < 5; ++j) {
    EXPECT_NEAR((x[j] - start[j]).norm(), 0, 1e-9);
    EXPECT_NEAR((previous[j] - next[j]).norm(), 0, 1e-9);
  }
}

TEST(Verlet, FixedAndMasslessJointsStay) {
  for (const VerletScope scope : {VerletScope::affected, VerletScope::all}) {
    Positions x = {{1, 0, 0}, {2, 0, 0}, {3, 0, 0}};
    const Positions previous(3, Vec3::Zero()), forces(3, Vec3(1, 1, 1));
    verlet(x, previous, forces, std::vector<double>{1, 0, 1}, Flags{1, 0, 0}, 1, scope);
    EXPECT_EQ(x[0], Vec3(1, 0, 0));
    EXPECT_EQ(x[1], Vec3(2, 0, 0));
    EXPECT_EQ(x[2], Vec3(7, 1, 1));
  }
}

// === Perturbation

TEST(Perturbation, NoneMovesNothingAndDrawsNothing) {
  Random random = dice(), untouched = dice();
  Positions x = {{1, 2, 3}};
  perturb(x, Flags{0}, PerturbationKind::none, 5, random);
  EXPECT_EQ(x[0], Vec3(1, 2, 3));
  EXPECT_EQ(random.next(), untouched.next());
}

TEST(Perturbation, GaussianCoordinatesHaveTheirMeanAndDeviation) {
  constexpr int n = 20000;
  const double size = 0.03;
  Vec3 sum = Vec3::Zero(), squares = Vec3::Zero();
  Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
  for (const Vec3& move : displacements(n, PerturbationKind::gaussian, size, dice())) {
    sum += move;
    squares += move.cwiseProduct(move);
    products += move * move.transpose();
  }
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(sum[axis] / n / size, 0, 0.036);
    EXPECT_NEAR(squares[axis] / n / (size * size), 1, 0.05);
    EXPECT_NEAR(products(axis, (axis + 1) % 3) / n / (size * size), 0, 0.036);
  }
}

TEST(Perturbation, BallIsFilledUniformlyAndNotLeft) {
  constexpr int n = 20000;
  const double size = 0.05;
  int shells[10] = {}, octants[8] = {};
  for (const Vec3& move : displacements(n, PerturbationKind::ball, size, dice())) {
    const double radius = move.norm() / size;
    ASSERT_LE(radius, 1 + 1e-12);
    ++shells[std::min(9, int(10 * std::pow(radius, 3)))];
    ++octants[(move[0] > 0) + 2 * (move[1] > 0) + 4 * (move[2] > 0)];
  }
  // shells of equal volume and octants alike, within five deviations
  for (const int shell : shells) EXPECT_NEAR(shell, n / 10, 215);
  for (const int octant : octants) EXPECT_NEAR(octant, n / 8, 235);
}

TEST(Perturbation, SameSeedAndStepMoveAlikeAndOthersDoNot) {
  for (const auto kind : {PerturbationKind::gaussian, PerturbationKind::ball}) {
    EXPECT_EQ(displacements(20, kind, 1, dice(3)), displacements(20, kind, 1, dice(3)));
    EXPECT_NE(displacements(20, kind, 1, dice(3)), displacements(20, kind, 1, dice(4)));
  }
}

TEST(Perturbation, FixedJointsStayAndLeaveTheOthersTheirNumbers) {
  for (const auto kind : {PerturbationKind::gaussian, PerturbationKind::ball}) {
    const Positions free = displacements(10, kind, 1, dice());
    Positions x(10, Vec3::Zero());
    Flags fixed(10, 0);
    fixed[0] = fixed[4] = 1;
    Random random = dice();
    perturb(x, fixed, kind, 1, random);
    for (std::size_t j = 0; j < 10; ++j) EXPECT_EQ(x[j], fixed[j] ? Vec3::Zero() : free[j]);
  }
}

// === Names

TEST(Break, NamesAreReadBack) {
  for (const char* name : {"affected", "all"}) EXPECT_EQ(name_of(verlet_scope(name)), name);
  for (const char* name : {"none", "gaussian", "ball"})
    EXPECT_EQ(name_of(perturbation_kind(name)), name);
}

TEST(Break, UnknownNamesAreRefusedWithTheKnownOnes) {
  EXPECT_EQ(refusal_of([] { verlet_scope("some"); }),
            "Verlet scope 'some' is not known; choose one of: affected, all");
  EXPECT_EQ(refusal_of([] { perturbation_kind(""); }),
            "perturbation '' is not known; choose one of: none, gaussian, ball");
}

}  // namespace
}  // namespace ragdoll
