#include "ragdoll/quality.h"

#include <algorithm>  // max, lower_bound, sort, find
#include <cmath>      // abs, sqrt, remainder
#include <utility>    // move, swap

#include "clash_radii.h"        // heavy_clash_radius, all_atom_clash_radius
#include "measures.h"           // angle, torsion
#include "ragdoll/cell_list.h"  // CellList
#include "ragdoll/error.h"      // Error

namespace ragdoll {
namespace {

constexpr double degree = degrees_per_radian;
constexpr double omega_off = 30;           // degree
constexpr double overlap_of_clash = 0.04;  // nm
constexpr double polar_allowance = 0.04;   // nm more for pairs of N and O
constexpr double bonded_hydrogen = 0.06;   // nm more for a polar hydrogen and an acceptor
constexpr double least_volume = 0.3;       // of unit vectors: sp3 has 0.77, a plane 0
constexpr int H = 1, N = 7, O = 8, S = 16;

/// Of unit vectors from the centre to three neighbours.
double unit_volume(std::span<const Vec3> x, int centre, int a, int b, int c) {
  const Vec3 u = (x[std::size_t(a)] - x[std::size_t(centre)]).normalized();
  const Vec3 v = (x[std::size_t(b)] - x[std::size_t(centre)]).normalized();
  const Vec3 w = (x[std::size_t(c)] - x[std::size_t(centre)]).normalized();
  return u.dot(v.cross(w));
}

struct RootMeanSquare {
  double squares = 0, largest = 0;
  std::size_t count = 0;

  void add(double value) {
    squares += value * value;
    largest = std::max(largest, std::abs(value));
    ++count;
  }
  double value() const { return count > 0 ? std::sqrt(squares / double(count)) : 0; }
};

}  // namespace

QualityCheck::QualityCheck(const Molecule& molecule, QualityTerms terms)
    : terms_(std::move(terms)), start_(molecule.positions()) {
  check_terms();
  for (const Bond& bond : molecule.bonds()) {
    bonds_.push_back({bond.a, bond.b});
    bond_lengths_.push_back((start_[std::size_t(bond.b)] - start_[std::size_t(bond.a)]).norm());
  }
  find_angles(molecule);
  for (const auto& omega : terms_.omegas)
    cis_.push_back(std::abs(torsion(start_, omega)) * degree < 90);
  find_hands(molecule);
  find_clashers(molecule);
}

void QualityCheck::check_terms() const {
  const auto check = [this](int atom) {
    if (atom < 0 || atom >= atom_count())
      throw Error("a term of quality names atom " + std::to_string(atom) +
                  ", which does not exist");
  };
  for (const IdealBond& bond : terms_.ideal_bonds)
    for (const int atom : {bond.a, bond.b}) check(atom);
  for (const IdealAngle& of : terms_.ideal_angles)
    for (const int atom : {of.a, of.b, of.c}) check(atom);
  for (const auto& omega : terms_.omegas)
    for (const int atom : omega) check(atom);
  for (const auto& backbone : terms_.backbones)
    for (const int atom : backbone) check(atom);
  for (const int atom : terms_.alphas) check(atom);
  for (const QualityBound& bound : terms_.bounds) {
    for (const int atom : {bound.p, bound.q}) check(atom);
    if (bound.group < 0 || bound.group >= terms_.groups)
      throw Error("a bound of quality is of group " + std::to_string(bound.group) + " of " +
                  std::to_string(terms_.groups));
  }
}

void QualityCheck::find_angles(const Molecule& molecule) {
  for (int centre = 0; centre < atom_count(); ++centre) {
    const auto& around = molecule.neighbours(centre);
    for (std::size_t i = 0; i < around.size(); ++i)
      for (std::size_t j = i + 1; j < around.size(); ++j)
        angles_.push_back({around[i].atom, centre, around[j].atom});
  }
  for (const auto& abc : angles_) angle_values_.push_back(angle(start_, abc));
}

void QualityCheck::find_hands(const Molecule& molecule) {
  std::vector<bool> alpha(start_.size());
  for (const int atom : terms_.alphas) alpha[std::size_t(atom)] = true;
  for (int centre = 0; centre < atom_count(); ++centre) {
    std::vector<int> around;
    for (const auto& [other, bond] : molecule.neighbours(centre))
      if (molecule.bonds()[std::size_t(bond)].order != BondOrder::dative) around.push_back(other);
    if (around.size() < 3 || around.size() > 4) continue;
    const std::size_t begin = hands_.size();
    // every three of the neighbours, so that none can go through the face of the others
    for (std::size_t left_out = 0; left_out < (around.size() == 3 ? 1U : 4U); ++left_out) {
      int three[3], count = 0;
      for (std::size_t k = 0; k < around.size(); ++k)
        if (around.size() == 3 || k != left_out) three[count++] = around[k];
      const double volume = unit_volume(start_, centre, three[0], three[1], three[2]);
      if (std::abs(volume) > least_volume)
        hands_.push_back({centre, three[0], three[1], three[2], volume > 0});
    }
    if (hands_.size() > begin)
      centres_.push_back({begin, hands_.size(), alpha[std::size_t(centre)]});
  }
}

void QualityCheck::find_clashers(const Molecule& molecule) {
  double largest = 0;
  for (int i = 0; i < atom_count(); ++i) {
    const int element = molecule.atoms()[std::size_t(i)].element;
    Clasher clasher;
    clasher.heavy_radius = float(heavy_clash_radius(element));
    clasher.all_atom_radius = float(all_atom_clash_radius(molecule, i));
    clasher.element = std::uint8_t(element);
    clasher.polar_hydrogen = is_polar_hydrogen(molecule, i);
    clasher.acceptor = is_acceptor(molecule, i);
    largest = std::max({largest, double(clasher.heavy_radius), double(clasher.all_atom_radius)});
    heavy_ += element != H;
    clashers_.push_back(clasher);
  }
  reach_ = 2 * largest - overlap_of_clash;

  // breadth first up to four bonds; a bond to a metal is none here
  std::vector<int> distance(start_.size(), -1), reached;
  const auto is_metal = [&](int atom) { return clashers_[std::size_t(atom)].all_atom_radius == 0; };
  near_begin_.push_back(0);
  for (int i = 0; i < atom_count(); ++i) {
    reached.assign(1, i);
    distance[std::size_t(i)] = 0;
    for (std::size_t k = 0; k < reached.size(); ++k) {
      const int from = reached[k];
      if (distance[std::size_t(from)] == 4 || is_metal(from)) continue;
      for (const auto& [other, bond] : molecule.neighbours(from))
        if (distance[std::size_t(other)] < 0) {
          distance[std::size_t(other)] = distance[std::size_t(from)] + 1;
          reached.push_back(other);
        }
    }
    std::vector<int> partners;
    for (const int other : reached)
      if (other > i) partners.push_back(other);
    std::sort(partners.begin(), partners.end());
    for (const int other : partners) {
      near_.push_back(other);
      near_bonds_.push_back(std::uint8_t(distance[std::size_t(other)]));
    }
    for (const int other : reached) distance[std::size_t(other)] = -1;
    near_begin_.push_back(near_.size());
  }
}

FrameQuality QualityCheck::measure(std::span<const Vec3> frame, const Box* box) const {
  if (frame.size() != start_.size())
    throw Error("a frame has " + std::to_string(frame.size()) + " positions instead of " +
                std::to_string(start_.size()));
  for (const Vec3& point : frame)
    if (!point.allFinite()) throw Error("a frame has a coordinate that is not finite");
  FrameQuality quality;
  add_internal(frame, quality);
  add_backbone(frame, quality);
  add_hands(frame, quality);
  add_clashes(frame, box, quality);
  quality.excess.assign(std::size_t(terms_.groups), 0);
  for (const QualityBound& bound : terms_.bounds) {
    Vec3 d = frame[std::size_t(bound.q)] - frame[std::size_t(bound.p)];
    if (box) d = box->minimum_image(d);
    double& excess = quality.excess[std::size_t(bound.group)];
    excess = std::max(excess, d.norm() - bound.length);
  }
  return quality;
}

void QualityCheck::add_internal(std::span<const Vec3> x, FrameQuality& q) const {
  RootMeanSquare bonds, angles, ideal_bonds, ideal_angles;
  const auto distance = [&](int a, int b) {
    return (x[std::size_t(b)] - x[std::size_t(a)]).norm();
  };
  for (std::size_t k = 0; k < bonds_.size(); ++k)
    bonds.add(distance(bonds_[k][0], bonds_[k][1]) - bond_lengths_[k]);
  for (std::size_t k = 0; k < angles_.size(); ++k)
    angles.add((angle(x, angles_[k]) - angle_values_[k]) * degree);
  for (const IdealBond& bond : terms_.ideal_bonds)
    ideal_bonds.add((distance(bond.a, bond.b) - bond.length) / bond.deviation);
  for (const IdealAngle& of : terms_.ideal_angles)
    ideal_angles.add((angle(x, {of.a, of.b, of.c}) * degree - of.degree) / of.deviation);
  q.bond_rms = bonds.value();
  q.bond_max = bonds.largest;
  q.angle_rms = angles.value();
  q.angle_max = angles.largest;
  q.bond_rmsz = ideal_bonds.value();
  q.angle_rmsz = ideal_angles.value();
}

void QualityCheck::add_backbone(std::span<const Vec3> x, FrameQuality& q) const {
  RootMeanSquare omegas;
  for (std::size_t k = 0; k < terms_.omegas.size(); ++k) {
    const double plane = cis_[k] ? 0 : 180;
    const double off = std::remainder(torsion(x, terms_.omegas[k]) * degree - plane, 360);
    omegas.add(off);
    q.omegas_off += std::abs(off) > omega_off;
  }
  q.omega_rms = omegas.value();
  q.omega_max = omegas.largest;
  if (!terms_.ramachandran) return;
  for (const auto& [c, n, ca, c1, n1] : terms_.backbones) {
    const double phi = torsion(x, {c, n, ca, c1}) * degree;
    const double psi = torsion(x, {n, ca, c1, n1}) * degree;
    const RamachandranRegion region = terms_.ramachandran->region(phi, psi);
    q.core += region == RamachandranRegion::core;
    q.outliers += region == RamachandranRegion::outlier;
  }
}

void QualityCheck::add_hands(std::span<const Vec3> x, FrameQuality& q) const {
  for (const Centre& centre : centres_) {
    bool kept = true;
    for (std::size_t k = centre.begin; k < centre.end; ++k) {
      const Hand& hand = hands_[k];
      const Vec3& o = x[std::size_t(hand.centre)];
      const double volume =
          (x[std::size_t(hand.a)] - o)
              .dot((x[std::size_t(hand.b)] - o).cross(x[std::size_t(hand.c)] - o));
      kept &= hand.positive ? volume > 0 : volume < 0;
    }
    if (kept) continue;
    ++q.centres_inverted;
    q.alphas_inverted += centre.alpha;
  }
}

void QualityCheck::add_clashes(std::span<const Vec3> x, const Box* box, FrameQuality& q) const {
  if (reach_ <= 0) return;
  const CellList cells(x, reach_, box);
  std::vector<CellPair> pairs;
  for (std::size_t cell = 0; cell < cells.cell_count(); ++cell) {
    pairs.clear();
    cells.find_candidates(cell, pairs);
    for (const CellPair& pair : pairs) {
      const Clasher &a = clashers_[std::size_t(pair.p)], &b = clashers_[std::size_t(pair.q)];
      const double heavy_sum =
          a.heavy_radius * b.heavy_radius > 0 ? double(a.heavy_radius) + double(b.heavy_radius) : 0;
      const double sum = a.all_atom_radius * b.all_atom_radius > 0
                             ? double(a.all_atom_radius) + double(b.all_atom_radius)
                             : 0;
      const double most = std::max(heavy_sum, sum) - overlap_of_clash;
      if (double(pair.distance) > most) continue;
      Vec3 d = x[std::size_t(pair.q)] - x[std::size_t(pair.p)];
      if (box) d = box->minimum_image(d);
      const double distance = d.norm();
      if (distance > most) continue;

      const auto begin = near_.begin() + std::ptrdiff_t(near_begin_[std::size_t(pair.p)]);
      const auto end = near_.begin() + std::ptrdiff_t(near_begin_[std::size_t(pair.p) + 1]);
      const auto found = std::lower_bound(begin, end, pair.q);
      const int apart =
          found != end && *found == pair.q ? near_bonds_[std::size_t(found - near_.begin())] : 5;
      const bool sulfurs = a.element == S && b.element == S;
      const auto polar = [](const Clasher& c) { return c.element == N || c.element == O; };
      if (apart > 4 && heavy_sum > 0 && !sulfurs) {
        const double allowed = overlap_of_clash + (polar(a) && polar(b) ? polar_allowance : 0);
        const double overlap = heavy_sum - distance;
        if (overlap >= allowed) {
          ++q.clashes;
          q.clash_worst = std::max(q.clash_worst, overlap - allowed);
        }
      }
      const bool hydrogen = a.element == H || b.element == H;
      if (apart > (hydrogen ? 4 : 3) && sum > 0) {
        const bool bonded = (a.polar_hydrogen && b.acceptor) || (b.polar_hydrogen && a.acceptor);
        const double allowed = overlap_of_clash + (bonded ? bonded_hydrogen : 0);
        q.all_atom_clashes += sum - distance >= allowed;
      }
    }
  }
}

}  // namespace ragdoll
