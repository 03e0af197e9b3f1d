// Frameworks and breaks at which solvers go wrong, for every solver: it converges, as a loop of our
// own finds, or it gives a reason; it neither hangs nor calls numbers positions that are none.

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>  // abs, sqrt, isfinite, max
#include <limits>
#include <string>

#include "block_examples.h"

namespace ragdoll {
namespace {

using namespace block_examples;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

struct Broken {
  std::string name;
  FrameworkParts parts;
  Positions x;
  std::vector<int> roots = {};
  bool can_be_met = false;  ///< then it is to be resolved, not only to be told of
  bool is_number = true;
};

FrameworkParts joints(std::size_t count) {
  FrameworkParts parts;
  parts.masses.assign(count, 1);
  return parts;
}

FrameworkParts ring(std::size_t count, double length) {
  FrameworkParts parts = joints(count);
  for (int j = 0; j < int(count); ++j) parts.bars.push_back({j, (j + 1) % int(count), length});
  return parts;
}

FrameworkParts complete(std::size_t count) {
  FrameworkParts parts = joints(count);
  for (int p = 0; p < int(count); ++p)
    for (int q = 0; q < p; ++q) parts.bars.push_back({q, p, 1});
  return parts;
}

Positions along_x(std::size_t count, double step) {
  Positions x;
  for (std::size_t j = 0; j < count; ++j) x.emplace_back(step * double(j), 0, 0);
  return x;
}

std::vector<Broken> all_broken() {
  std::vector<Broken> all;
  all.push_back({"one joint", joints(1), {{3, 4, 5}}, {0}, true});
  all.push_back({"no bars", joints(5), along_x(5, 1), {2}, true});
  all.push_back({"all at one place", ring(6, 1), Positions(6, Vec3(1, 2, 3)), {1}, true});
  all.push_back({"two at one place", ring(4, 1), {{0, 0, 0}, {0, 0, 0}, {1, 1, 0}, {0, 1, 0}}});
  all.push_back({"collinear", ring(5, 1), along_x(5, 0.7), {0}});
  all.push_back({"coplanar", complete(4), {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {0}});
  Broken held = {"bar between fixed joints", joints(3), along_x(3, 2)};
  held.parts.bars = {{0, 1, 1}, {1, 2, 1}};
  held.parts.fixed = {1, 1, 0};
  all.push_back(held);
  held.name = "all fixed";
  held.parts.fixed = {1, 1, 1};
  held.roots = {1};
  all.push_back(held);
  Broken triangle = {"triangle inequality", ring(3, 1), {{0, 0, 0}, {1, 0, 0}, {0.5, 0.8, 0}}, {1}};
  triangle.parts.bars[2].length = 3;
  all.push_back(triangle);
  Random random(1, RandomStream::generate, 0);
  all.push_back({"K5", complete(5), examples::random_points(5, 1, random), {2}});
  all.push_back({"K5 at one place", complete(5), Positions(5, Vec3(1, 1, 1)), {2}});
  all.push_back({"K4 squashed flat", complete(4), along_x(4, 0.5), {3}});
  Broken lengths = {"lengths of 1e-9 and 1e9",
                    ring(4, 1),
                    {{0, 0, 0}, {1e9, 0, 0}, {1e9, 1e-9, 0}, {0, 0, 1e9}},
                    {0}};
  lengths.parts.bars = {{0, 1, 1e9}, {1, 2, 1e-9}, {2, 3, 1.4e9}, {3, 0, 1e9}};
  all.push_back(lengths);
  const Structure two_cycle = generate_structure({.class_name = "2-cycle", .joints = 24});
  const auto forced = [&](const std::string& name, const Vec3& by, bool can_be_met, bool number) {
    Broken broken = {name, two_cycle.parts, two_cycle.positions, {5}, can_be_met, number};
    broken.x[5] += by;
    all.push_back(broken);
  };
  forced("force of zero", Vec3::Zero(), true, true);
  forced("force of 1e6", Vec3(1e6, -3e5, 7e5), false, true);
  forced("force of 1e300", Vec3(1e300, 0, 1e300), false, true);
  forced("force that is no number", Vec3(nan, 0, 0), false, false);
  forced("force without bound", Vec3(0, -infinity, 0), false, false);
  Broken distant = {"far from the origin", two_cycle.parts, two_cycle.positions, {5}};
  for (Vec3& point : distant.x) point += Vec3(1e6, -1e6, 1e6);
  distant.x[5] += Vec3(0.4, 0.3, 0.1);
  all.push_back(distant);
  Broken parts = {"several components",
                  joints(7),
                  {{0, 0, 0}, {2, 0, 0}, {9, 0, 0}, {9, 2, 0}, {9, 1, 0}, {20, 0, 0}, {20, 0, 0}},
                  {1, 5}};
  parts.parts.bars = {{0, 1, 1}, {2, 3, 1}, {3, 4, 1}, {4, 2, 1}, {5, 6, 1}};
  all.push_back(parts);
  Broken kinds = {"every kind of constraint", ring(6, 1), along_x(6, 0.4), {2}};
  kinds.parts.tethers = {{0, 3, 0.5}};
  kinds.parts.contacts = {{1, 4, 1.2}};
  kinds.parts.volumes = {{0, 1, 2, 3, 0.1, infinity, 1}};
  all.push_back(kinds);
  kinds.name = "tether against contact";
  kinds.parts.contacts.push_back({0, 3, 0.9});
  all.push_back(kinds);
  return all;
}

/// By a loop of its own; infinite where something is no number.
double violation_of(const FrameworkParts& parts, const Positions& x) {
  double worst = 0;
  const auto length = [&](int p, int q) {
    const Vec3 d = x[std::size_t(q)] - x[std::size_t(p)];
    return std::sqrt(d.dot(d));
  };
  const auto consider = [&](double relative) {
    worst = std::isfinite(relative) ? std::max(worst, relative) : infinity;
  };
  for (const Bar& b : parts.bars) consider(std::abs(length(b.p, b.q) - b.length) / b.length);
  for (const Tether& t : parts.tethers) consider((length(t.p, t.q) - t.length) / t.length);
  for (const Contact& c : parts.contacts) consider((c.length - length(c.p, c.q)) / c.length);
  for (const Volume& v : parts.volumes) {
    const Vec3& a = x[std::size_t(v.a)];
    const Vec3 b = x[std::size_t(v.b)] - a, c = x[std::size_t(v.c)] - a,
               d = x[std::size_t(v.d)] - a;
    consider((v.lower - b.dot(c.cross(d))) / v.scale);
  }
  return worst;
}

class EverySolver : public testing::TestWithParam<std::string> {};

TEST_P(EverySolver, AnswersOrGivesAReason) {
  for (const Broken& broken : all_broken())
    for (const double tolerance : {1e-15, 1e-9, 1e-3, 10.0})
      for (const long most : {1L, 300L})
        for (const bool all_moved : {false, true}) {
          const std::string where = GetParam() + ": " + broken.name + ", tolerance " +
                                    std::to_string(tolerance) + ", at most " +
                                    std::to_string(most) + (all_moved ? ", all moved" : "");
          const auto start = std::chrono::steady_clock::now();
          const auto resolver =
              make_resolver(examples::framework_of(broken.parts),
                            {.solver = GetParam(), .tolerance = tolerance, .max_iterations = most});
          Positions x = broken.x;
          const std::vector<int> roots = all_moved ? std::vector<int>{} : broken.roots;
          const ResolveReport report = resolver->resolve(x, {.roots = roots});
          const double violation = violation_of(broken.parts, x);
          // rounding of this loop and of the solver's may differ
          const double size = std::max(1.0, x.front().norm());
          if (report.converged) {
            EXPECT_LE(violation, tolerance + 1e-14 * size) << where;
          } else {
            EXPECT_NE(report.worst, "") << where;
          }
          const bool said_whole = report.reason == StopReason::nothing_broken ||
                                  report.reason == StopReason::within_tolerance;
          EXPECT_EQ(report.converged, said_whole) << where;
          EXPECT_LE(report.iterations, most) << where;
          if (!broken.is_number) {
            EXPECT_EQ(report.reason, StopReason::not_finite) << where;
          }
          if (broken.can_be_met && tolerance > 1e-12 && most > 1) {
            EXPECT_TRUE(report.converged) << where << ": " << report.worst;
          }
          for (const Vec3& point : x) EXPECT_TRUE(!report.converged || point.allFinite()) << where;
          // a guard against hanging, not a measurement
          EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20)) << where;
        }
}

TEST_P(EverySolver, FixedJointsStayWhateverBreaks) {
  for (Broken broken : all_broken()) {
    if (!broken.is_number) continue;
    broken.parts.fixed.assign(broken.x.size(), 0);
    broken.parts.fixed.back() = 1;
    Positions x = broken.x;
    const ResolveReport report = make_resolver(examples::framework_of(broken.parts),
                                               {.solver = GetParam(), .max_iterations = 200})
                                     ->resolve(x, {.roots = broken.roots});
    // once numbers ran out, no position means anything
    if (report.reason == StopReason::not_finite) continue;
    EXPECT_EQ(x.back(), broken.x.back()) << broken.name;
  }
}

TEST_P(EverySolver, ResolvesTheNextBreakAfterOneThatIsNoNumber) {
  const Structure structure = generate_structure({.class_name = "1-cycle", .joints = 16});
  const auto resolver = make_resolver(framework_of(structure), {.solver = GetParam()});
  for (const double bad : {nan, infinity, 1e300}) {
    Positions x = structure.positions;
    x[3][1] = bad;
    EXPECT_FALSE(resolver->resolve(x, {.roots = std::vector<int>{3}}).converged) << bad;
    x = structure.positions;
    x[5] += Vec3(1, 0, 0);
    EXPECT_TRUE(resolver->resolve(x, {.roots = std::vector<int>{5}}).converged) << bad;
    EXPECT_LE(violation_of(structure.parts, x), 1e-3);
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, EverySolver, testing::ValuesIn(solver_names()),
                         [](const auto& solver) { return solver.param; });

}  // namespace
}  // namespace ragdoll
