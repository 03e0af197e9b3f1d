#include "ragdoll/stacked_rings.h"

#include <algorithm>  // sort, find, min_element, unique
#include <array>
#include <cmath>    // abs, cos, isfinite
#include <numbers>  // pi
#include <tuple>    // tie

#include <Eigen/Eigenvalues>  // SelfAdjointEigenSolver

#include "chemistry_rules.h"    // van_der_waals_radius
#include "ragdoll/cell_list.h"  // CellList
#include "ragdoll/error.h"      // Error

namespace ragdoll {
namespace {

/// Centres may not lie side by side: the least share of their distance that is along the normals.
constexpr double least_rise = 0.55;
constexpr int held_pairs = 3;

struct Ring {
  std::vector<int> atoms;  ///< sorted
  Vec3 centre = Vec3::Zero(), normal = Vec3::Zero();
};

/// Finds rings of five and six aromatic bonds.
class RingFinder {
 public:
  explicit RingFinder(const Molecule& molecule) : molecule_(molecule) {}

  std::vector<Ring> find() {
    for (int atom = 0; atom < int(molecule_.atoms().size()); ++atom) {
      path_.assign(1, atom);
      walk();
    }
    std::vector<Ring> rings;
    for (const std::vector<int>& atoms : found_) {
      Ring ring;
      ring.atoms = atoms;
      for (const int atom : atoms) ring.centre += at(atom) / double(atoms.size());
      Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
      for (const int atom : atoms) {
        const Vec3 d = at(atom) - ring.centre;
        spread += d * d.transpose();
      }
      ring.normal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(0);
      rings.push_back(ring);
    }
    return rings;
  }

 private:
  const Vec3& at(int atom) const { return molecule_.positions()[std::size_t(atom)]; }

  /// Goes on from the path's end, over later atoms than its start.
  void walk() {
    for (const auto& [next, bond] : molecule_.neighbours(path_.back())) {
      if (molecule_.bonds()[std::size_t(bond)].order != BondOrder::aromatic) continue;
      // each ring is met in both directions; one is taken
      if (next == path_.front() && path_.size() >= 5 && path_[1] < path_.back()) {
        std::vector<int> ring = path_;
        std::sort(ring.begin(), ring.end());
        found_.push_back(std::move(ring));
      }
      if (next <= path_.front() || path_.size() == 6 ||
          std::find(path_.begin(), path_.end(), next) != path_.end())
        continue;
      path_.push_back(next);
      walk();
      path_.pop_back();
    }
  }

  const Molecule& molecule_;
  std::vector<int> path_;
  std::vector<std::vector<int>> found_;
};

bool share_atoms(const Ring& one, const Ring& other) {
  return std::any_of(one.atoms.begin(), one.atoms.end(), [&](int atom) {
    return std::binary_search(other.atoms.begin(), other.atoms.end(), atom);
  });
}

bool are_stacked(const Ring& one, const Ring& other, const StackedRingOptions& options) {
  const Vec3 d = other.centre - one.centre;
  const double distance = d.norm();
  if (!(distance <= options.distance) || distance == 0 || share_atoms(one, other)) return false;
  if (std::abs(one.normal.dot(other.normal)) <
      std::cos(options.angle_degree * std::numbers::pi / 180))
    return false;
  return std::max(std::abs(one.normal.dot(d)), std::abs(other.normal.dot(d))) >=
         least_rise * distance;
}

}  // namespace

std::vector<StackedPair> stacked_rings(const Molecule& molecule,
                                       const StackedRingOptions& options) {
  if (!std::isfinite(options.distance) || !std::isfinite(options.angle_degree) ||
      !std::isfinite(options.margin))
    throw Error("distance, angle and margin of stacked rings are to be numbers");
  const std::vector<Ring> rings = RingFinder(molecule).find();
  std::vector<StackedPair> held;
  if (rings.size() < 2 || options.distance <= 0) return held;
  std::vector<Vec3> centres;
  for (const Ring& ring : rings) centres.push_back(ring.centre);
  std::vector<CellPair> pairs;
  const CellList cells(centres, options.distance * (1 + 1e-9), nullptr);
  for (std::size_t cell = 0; cell < cells.cell_count(); ++cell) cells.find_candidates(cell, pairs);

  const auto radius = [&](int atom) {
    return van_der_waals_radius(molecule.atoms()[std::size_t(atom)].element);
  };
  for (const CellPair& pair : pairs) {
    const Ring &one = rings[std::size_t(pair.p)], &other = rings[std::size_t(pair.q)];
    if (!are_stacked(one, other, options)) continue;
    std::vector<StackedPair> all;
    for (const int p : one.atoms)
      for (const int q : other.atoms) {
        const double distance =
            (molecule.positions()[std::size_t(q)] - molecule.positions()[std::size_t(p)]).norm();
        const double bound = std::max(distance, radius(p) + radius(q) + options.margin);
        all.push_back({p, q, distance, bound});
      }
    std::sort(all.begin(), all.end(), [](const StackedPair& a, const StackedPair& b) {
      return std::tie(a.distance, a.a, a.b) < std::tie(b.distance, b.a, b.b);
    });
    // each atom once, so that the pairs spread over the rings
    std::vector<int> taken;
    for (const StackedPair& candidate : all) {
      if (taken.size() == 2 * held_pairs) break;
      if (std::find(taken.begin(), taken.end(), candidate.a) != taken.end() ||
          std::find(taken.begin(), taken.end(), candidate.b) != taken.end())
        continue;
      taken.insert(taken.end(), {candidate.a, candidate.b});
      held.push_back(candidate);
      if (held.back().a > held.back().b) std::swap(held.back().a, held.back().b);
    }
  }
  std::sort(held.begin(), held.end(), [](const StackedPair& a, const StackedPair& b) {
    return std::tie(a.a, a.b) < std::tie(b.a, b.b);
  });
  held.erase(std::unique(held.begin(), held.end(),
                         [](const StackedPair& a, const StackedPair& b) {
                           return a.a == b.a && a.b == b.b;
                         }),
             held.end());
  return held;
}

}  // namespace ragdoll
