#include "ragdoll/random_start.h"

#include <algorithm>  // sort, unique, fill
#include <cmath>      // cbrt, sqrt
#include <string>
#include <utility>  // move, pair

#include "chemistry_rules.h"   // van_der_waals_radius, polarity_of
#include "ragdoll/error.h"     // Error
#include "ragdoll/random.h"    // Random
#include "ragdoll/resolver.h"  // make_resolver, inverted_centres

namespace ragdoll {
namespace {

/// Joints are drawn about one point, this far times the cube root of their number. nm
constexpr double spread = 0.12;

/// No attempt is worth more iterations than this.
constexpr long most_iterations = 400;

/// Pairs of the contact rule nearer than so many times their bound are pushed apart, by this share
/// of what they lack and no joint further than the last; at most so often.
constexpr double push_reach = 1.25, push_share = 0.8, push_most = 0.05;  // nm
constexpr int most_pushes = 300;

/// As build_framework has it. nm
constexpr double heavy_allowance = 0.01, hydrogen_allowance = 0.05;

ContactRule rule_of(const Molecule& molecule, std::span<const DistanceBounds> distances,
                    double scale) {
  ContactRule rule;
  rule.scale = scale;
  rule.heavy_allowance = heavy_allowance;
  rule.hydrogen_allowance = hydrogen_allowance;
  const int n = int(molecule.atoms().size());
  std::vector<std::vector<int>> partners(static_cast<std::size_t>(n));
  for (const DistanceBounds& pair : distances)
    partners[std::size_t(std::min(pair.p, pair.q))].push_back(std::max(pair.p, pair.q));
  rule.exclusion_begin.push_back(0);
  for (int i = 0; i < n; ++i) {
    rule.radii.push_back(van_der_waals_radius(molecule.atoms()[std::size_t(i)].element));
    rule.polarity.push_back(polarity_of(molecule, i));
    std::vector<int>& of = partners[std::size_t(i)];
    for (const auto& one : molecule.neighbours(i)) {
      of.push_back(one.atom);
      for (const auto& two : molecule.neighbours(one.atom)) {
        of.push_back(two.atom);
        for (const auto& three : molecule.neighbours(two.atom)) of.push_back(three.atom);
      }
    }
    std::sort(of.begin(), of.end());
    of.erase(std::unique(of.begin(), of.end()), of.end());
    for (const int q : of)
      if (q > i) rule.exclusions.push_back(q);
    rule.exclusion_begin.push_back(int(rule.exclusions.size()));
  }
  return rule;
}

/// Pairs that the contact rule holds, and how near they may be pushed.
struct Push {
  struct Pair {
    int p, q;
    double bound;  ///< nm
  };
  std::vector<Pair> pairs;
  std::vector<Vec3> moves;

  explicit Push(const Framework& framework) : moves(std::size_t(framework.joint_count())) {
    const ContactRule& rule = framework.contact_rule();
    if (rule.empty()) return;
    for (int p = 0; p < framework.joint_count(); ++p)
      for (int q = p + 1; q < framework.joint_count(); ++q)
        if (!rule.excluded(p, q)) pairs.push_back({p, q, rule.bound(p, q)});
  }

  /// Moves what is too near. Joints may pass through each other: the push is the weaker, the nearer
  /// they are to one place. @return whether any pair was nearer than its bound
  bool apply(std::span<Vec3> x) {
    std::fill(moves.begin(), moves.end(), Vec3::Zero());
    bool broken = false;
    for (const Pair& pair : pairs) {
      const Vec3 d = x[std::size_t(pair.q)] - x[std::size_t(pair.p)];
      const double reach = push_reach * pair.bound, square = d.squaredNorm();
      if (square >= reach * reach || square == 0) continue;
      const double distance = std::sqrt(square);
      broken = broken || distance < pair.bound;
      const Vec3 move = push_share / 2 * (reach - distance) / (distance + 0.3 * reach) * d;
      moves[std::size_t(pair.q)] += move;
      moves[std::size_t(pair.p)] -= move;
    }
    if (broken)
      for (std::size_t j = 0; j < moves.size(); ++j) {
        const double length = moves[j].norm();
        x[j] += length > push_most ? Vec3(push_most / length * moves[j]) : moves[j];
      }
    return broken;
  }
};

}  // namespace

Framework ideal_framework(const Molecule& molecule, std::span<const DistanceBounds> distances,
                          std::span<const Volume> volumes, double contact_scale) {
  if (!(contact_scale > 0) || !(contact_scale <= 1.5))
    throw Error("the contact scale must be above 0 and at most 1.5");
  const int n = int(molecule.atoms().size());
  FrameworkParts parts;
  for (const Atom& atom : molecule.atoms()) {
    parts.masses.push_back(atom.mass);
    parts.labels.push_back(atom.label);
  }
  for (const auto& [p, q, lower, upper] : distances) {
    if (p < 0 || q < 0 || p >= n || q >= n)
      throw Error("bounds name atom " + std::to_string(std::max(p, q)) + ", but there are " +
                  std::to_string(n));
    if (!(lower > 0) || !(lower <= upper))
      throw Error("the bounds of " + molecule.name(p) + " and " + molecule.name(q) +
                  " are out of order");
    if (lower == upper) {
      bool bonded = false;
      for (const auto& [other, bond] : molecule.neighbours(p)) bonded = bonded || other == q;
      parts.bars.push_back({p, q, lower, bonded ? BarKind::bond : BarKind::angle});
    } else {
      parts.tethers.push_back({p, q, upper, TetherKind::user});
      parts.contacts.push_back({p, q, lower, ContactKind::user});
    }
  }
  parts.volumes.assign(volumes.begin(), volumes.end());
  parts.contact_rule = rule_of(molecule, distances, contact_scale);
  return Framework(std::move(parts));
}

RandomStart random_start(const Framework& framework, const RandomStartSettings& settings) {
  if (settings.attempts < 1) throw Error("the number of attempts must be 1 or more");
  FrameworkParts parts = framework.parts();
  parts.contact_rule = {};
  const ResolverSettings resolver{
      .solver = "newton", .tolerance = settings.tolerance, .max_iterations = most_iterations};
  const auto alone = make_resolver(std::make_shared<const Framework>(std::move(parts)), resolver);
  const auto crowded = make_resolver(std::make_shared<const Framework>(framework), resolver);
  Push push(framework);
  RandomStart start;
  std::vector<Vec3> x(std::size_t(framework.joint_count()));
  const double size = spread * std::cbrt(double(x.size()));
  for (start.attempts = 1; start.attempts <= settings.attempts; ++start.attempts) {
    Random random(settings.seed, RandomStream::generate, std::uint64_t(start.attempts));
    for (Vec3& place : x)
      place = size * Vec3(random.gaussian(), random.gaussian(), random.gaussian());
    bool resolved = alone->resolve(x, {}).converged;
    for (int round = 0; resolved && round < most_pushes && push.apply(x); ++round)
      resolved = alone->resolve(x, {}).converged;
    if (!resolved || !crowded->resolve(x, {}).converged || inverted_centres(framework, x) > 0)
      continue;
    start.positions = std::move(x);
    return start;
  }
  --start.attempts;
  return start;
}

}  // namespace ragdoll
