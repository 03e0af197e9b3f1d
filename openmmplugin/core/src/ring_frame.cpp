#include "ring_frame.h"

#include <algorithm>  // sort, min, max, lower_bound
#include <cmath>      // abs
#include <limits>     // infinity
#include <utility>    // swap

namespace ragdoll {
namespace {

/// As build_framework has it: a centre that is flatter has no hand, and what is kept of its volume.
constexpr double least_volume = 0.02, kept_share = 0.5;

template <class Pair>
std::vector<Pair> pairs_among(const std::vector<Pair>& pairs, const std::vector<int>& number) {
  std::vector<Pair> kept;
  for (Pair pair : pairs) {
    pair.p = number[std::size_t(pair.p)];
    pair.q = number[std::size_t(pair.q)];
    if (pair.p >= 0 && pair.q >= 0) kept.push_back(pair);
  }
  return kept;
}

ContactRule rule_among(const ContactRule& rule, std::span<const int> joints,
                       const std::vector<int>& number) {
  ContactRule kept;
  if (rule.empty()) return kept;
  kept.scale = rule.scale;
  kept.heavy_allowance = rule.heavy_allowance;
  kept.hydrogen_allowance = rule.hydrogen_allowance;
  std::vector<std::vector<int>> partners(joints.size());
  for (std::size_t k = 0; k < joints.size(); ++k) {
    const std::size_t joint = std::size_t(joints[k]);
    kept.radii.push_back(rule.radii[joint]);
    kept.polarity.push_back(rule.polarity[joint]);
    for (int e = rule.exclusion_begin[joint]; e < rule.exclusion_begin[joint + 1]; ++e) {
      const int other = number[std::size_t(rule.exclusions[std::size_t(e)])];
      if (other >= 0)
        partners[std::size_t(std::min(int(k), other))].push_back(std::max(int(k), other));
    }
  }
  kept.exclusion_begin.push_back(0);
  for (std::vector<int>& of : partners) {
    std::sort(of.begin(), of.end());
    kept.exclusions.insert(kept.exclusions.end(), of.begin(), of.end());
    kept.exclusion_begin.push_back(int(kept.exclusions.size()));
  }
  for (ClosePair pair : pairs_among(rule.close_pairs, number)) {
    if (pair.p > pair.q) std::swap(pair.p, pair.q);
    kept.close_pairs.push_back(pair);
  }
  std::sort(
      kept.close_pairs.begin(), kept.close_pairs.end(),
      [](const ClosePair& a, const ClosePair& b) { return a.p != b.p ? a.p < b.p : a.q < b.q; });
  return kept;
}

}  // namespace

FrameworkParts restricted(const FrameworkParts& parts, std::span<const int> joints) {
  std::vector<int> number(parts.masses.size(), -1);
  for (std::size_t k = 0; k < joints.size(); ++k) number[std::size_t(joints[k])] = int(k);
  FrameworkParts kept;
  kept.masses.assign(joints.size(), 12);
  kept.bars = pairs_among(parts.bars, number);
  kept.tethers = pairs_among(parts.tethers, number);
  kept.contacts = pairs_among(parts.contacts, number);
  for (Volume volume : parts.volumes) {
    bool inside = true;
    for (int* corner : {&volume.a, &volume.b, &volume.c, &volume.d}) {
      *corner = number[std::size_t(*corner)];
      inside = inside && *corner >= 0;
    }
    if (inside) kept.volumes.push_back(volume);
  }
  kept.contact_rule = rule_among(parts.contact_rule, joints, number);
  return kept;
}

void add_ring_centres(const Molecule& molecule, const PliantRings& pliant,
                      std::span<const int> atoms, FrameworkParts& parts) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const std::vector<Vec3>& x = molecule.positions();
  for (std::size_t k = 0; k < atoms.size(); ++k) {
    const int centre = atoms[k];
    if (molecule.neighbours(centre).size() != 4) continue;
    std::vector<int> others;
    for (const auto& [other, bond] : molecule.neighbours(centre))
      if (pliant.in_ring(bond)) others.push_back(other);
    if (others.size() != 3) continue;
    double product = 1;
    for (const int other : others)
      product *= (x[std::size_t(other)] - x[std::size_t(centre)]).norm();
    const auto at = [&](int which) -> const Vec3& {
      return x[std::size_t(others[std::size_t(which)])];
    };
    const double volume = signed_volume(x[std::size_t(centre)], at(0), at(1), at(2));
    if (std::abs(volume) < least_volume * product) continue;
    const auto local = [&](int which) {
      return int(std::lower_bound(atoms.begin(), atoms.end(), others[std::size_t(which)]) -
                 atoms.begin());
    };
    const double kept = kept_share * volume;
    parts.volumes.push_back({int(k), local(0), local(1), local(2), volume > 0 ? kept : -infinity,
                             volume > 0 ? infinity : kept, std::abs(volume),
                             VolumeKind::chirality});
  }
}

void write_out_contacts(FrameworkParts& parts) {
  const ContactRule& rule = parts.contact_rule;
  if (rule.empty()) return;
  const int n = int(parts.masses.size());
  for (int p = 0; p < n; ++p)
    for (int q = p + 1; q < n; ++q)
      if (!rule.excluded(p, q))
        parts.contacts.push_back({p, q, rule.bound(p, q), ContactKind::user});
  parts.contact_rule = {};
}

}  // namespace ragdoll
