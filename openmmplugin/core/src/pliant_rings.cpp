#include "pliant_rings.h"

#include <algorithm>  // min, max, clamp
#include <array>
#include <cmath>  // acos, cos, sqrt, isfinite
#include <cstdint>
#include <map>
#include <numbers>  // pi

#include "ragdoll/ring_conformers.h"
#include "surroundings.h"  // surroundings

namespace ragdoll {
namespace {

constexpr int nitrogen = 7;  // atomic number

/// Planar units across loosened angles keep their 1-4 distances to within this, relative: what
/// their torsions may do is for their volumes.
constexpr double planar_play = 0.025;

/// Of angles that are alike.
struct Mean {
  double sum = 0;
  int count = 0;
};

int bond_between(const Molecule& molecule, int p, int q) {
  for (const auto& [other, bond] : molecule.neighbours(p))
    if (other == q) return bond;
  return -1;
}

}  // namespace

PliantRings::PliantRings(const Molecule& molecule, std::span<const RingSystem> systems)
    : molecule_(molecule),
      units_(molecule),
      in_ring_(molecule.bonds().size()),
      inverts_(molecule.atoms().size()) {
  std::vector<int> ring_bonds(molecule.atoms().size()), smallest(molecule.atoms().size(), 1 << 30);
  for (const RingSystem& system : systems)
    for (std::size_t k = 0; k < system.bonds.size(); ++k) {
      const Bond& bond = molecule.bonds()[std::size_t(system.bonds[k])];
      in_ring_[std::size_t(system.bonds[k])] = 1;
      for (const int atom : {bond.a, bond.b}) {
        ++ring_bonds[std::size_t(atom)];
        smallest[std::size_t(atom)] = std::min(smallest[std::size_t(atom)], system.ring_size[k]);
      }
    }
  for (int atom = 0; atom < int(molecule.atoms().size()); ++atom)
    inverts_[std::size_t(atom)] = molecule.atoms()[std::size_t(atom)].element == nitrogen &&
                                  molecule.neighbours(atom).size() == 3 &&
                                  ring_bonds[std::size_t(atom)] == 2 &&
                                  smallest[std::size_t(atom)] > 3 && !units_.planar_atom(atom);
}

/// One-sided planarity volumes keep puckers; those of planar units have two bounds.
bool PliantRings::is_left_out(const Volume& volume) const {
  if (volume.kind == VolumeKind::planarity) {
    if (std::isfinite(volume.lower) && std::isfinite(volume.upper)) return false;
    const int bond = bond_between(molecule_, volume.b, volume.c);
    return bond >= 0 && in_ring(bond);
  }
  return molecule_.neighbours(volume.a).size() == 3 && inverts(volume.a) &&
         bond_between(molecule_, volume.a, volume.b) >= 0 &&
         bond_between(molecule_, volume.a, volume.c) >= 0 &&
         bond_between(molecule_, volume.a, volume.d) >= 0;
}

FrameworkParts PliantRings::loosen(const FrameworkParts& parts, double play) const {
  FrameworkParts loose = parts;
  loose.bars.clear();
  const std::vector<Vec3>& x = molecule_.positions();
  const std::vector<std::uint64_t> colour = surroundings(molecule_);
  const auto key_of = [&](int p, int middle, int q) {
    const std::uint64_t one = colour[std::size_t(p)], other = colour[std::size_t(q)];
    return std::array<std::uint64_t, 3>{colour[std::size_t(middle)], std::min(one, other),
                                        std::max(one, other)};
  };
  std::map<std::array<std::uint64_t, 3>, Mean> means;
  for (const Bar& bar : parts.bars) {
    if (bar.kind != BarKind::angle) continue;
    for (const auto& [middle, first] : molecule_.neighbours(bar.p)) {
      const int second = bond_between(molecule_, middle, bar.q);
      if (second < 0 || !gives(first, second)) continue;
      const Vec3 a = x[std::size_t(bar.p)] - x[std::size_t(middle)];
      const Vec3 b = x[std::size_t(bar.q)] - x[std::size_t(middle)];
      Mean& mean = means[key_of(bar.p, middle, bar.q)];
      mean.sum += std::acos(std::clamp(a.dot(b) / (a.norm() * b.norm()), -1.0, 1.0));
      ++mean.count;
    }
  }
  for (std::size_t k = 0; k < parts.bars.size(); ++k) {
    const Bar& bar = parts.bars[k];
    double lower = bar.length, upper = bar.length;
    bool gave = false;
    if (bar.kind == BarKind::angle) {
      for (const auto& [middle, first] : molecule_.neighbours(bar.p)) {
        const int second = bond_between(molecule_, middle, bar.q);
        if (second < 0 || !gives(first, second)) continue;
        const double r = (x[std::size_t(bar.p)] - x[std::size_t(middle)]).norm();
        const double s = (x[std::size_t(bar.q)] - x[std::size_t(middle)]).norm();
        const Mean& mean = means.at(key_of(bar.p, middle, bar.q));
        const double angle = mean.sum / mean.count;
        const auto distance = [&](double at) {
          return std::sqrt(r * r + s * s - 2 * r * s * std::cos(at));
        };
        const double least = distance(std::max(angle - play, 0.1));
        const double most = distance(std::min(angle + play, std::numbers::pi));
        // across two centres, as in rings of four: what either wants
        lower = gave ? std::min(lower, least) : least;
        upper = gave ? std::max(upper, most) : most;
        gave = true;
      }
    } else if (bar.kind == BarKind::planar) {
      for (const auto& [b, ab] : molecule_.neighbours(bar.p))
        for (const auto& [c, bc] : molecule_.neighbours(b)) {
          const int cd = bond_between(molecule_, c, bar.q);
          if (c == bar.p || cd < 0 || !(gives(ab, bc) || gives(bc, cd))) continue;
          lower = std::min(lower, bar.length * (1 - planar_play));
          upper = std::max(upper, bar.length * (1 + planar_play));
        }
    }
    if (lower == upper) {
      loose.bars.push_back(bar);
      continue;
    }
    loose.tethers.push_back({bar.p, bar.q, upper, TetherKind::user});
    loose.contacts.push_back({bar.p, bar.q, lower, ContactKind::user});
  }
  std::erase_if(loose.volumes, [this](const Volume& v) { return is_left_out(v); });
  return loose;
}

Framework with_pliant_rings(const Framework& framework, const Molecule& molecule,
                            std::span<const RingSystem> systems, double angle_play_degree) {
  return Framework(PliantRings(molecule, systems)
                       .loosen(framework.parts(), angle_play_degree * std::numbers::pi / 180));
}

}  // namespace ragdoll
