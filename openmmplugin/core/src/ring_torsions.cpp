#include "ring_torsions.h"

#include <algorithm>  // sort, min, find
#include <cmath>      // atan2, sin, cos, sqrt, abs
#include <limits>     // infinity
#include <map>
#include <numbers>  // pi
#include <utility>  // move

#include "surroundings.h"  // surroundings

namespace ragdoll {
namespace {

/// Terms of less amplitude than this have less of a say. kJ/mol
constexpr double weak = 1.5;

/// No torsion is led further than this at once. rad
constexpr double furthest = 0.35;

/// Symmetries beyond so many are not looked for, nor do symmetries matter where atoms are more.
constexpr std::size_t most_symmetries = 96;

/// Permutations of a ring system's atoms that keep bonds, surroundings, and the hand of centres.
class Automorphisms {
 public:
  Automorphisms(const Molecule& molecule, const RingSystem& system)
      : molecule_(molecule),
        atoms_(system.atoms),
        colour_(surroundings(molecule)),
        neighbours_(atoms_.size()),
        image_(atoms_.size(), -1),
        taken_(atoms_.size()) {
    for (const int bond : system.bonds) {
      const Bond& of = molecule.bonds()[std::size_t(bond)];
      const int a = local(of.a), b = local(of.b);
      neighbours_[std::size_t(a)].push_back({b, int(of.order)});
      neighbours_[std::size_t(b)].push_back({a, int(of.order)});
    }
    // each after a neighbour of it, so that few images are tried
    order_ = {0};
    std::vector<unsigned char> seen(atoms_.size());
    seen[0] = 1;
    for (std::size_t k = 0; k < order_.size(); ++k)
      for (const auto& [other, bond] : neighbours_[std::size_t(order_[k])])
        if (!seen[std::size_t(other)]) {
          seen[std::size_t(other)] = 1;
          order_.push_back(other);
        }
    extend(0);
  }

  std::vector<std::vector<int>> found;

 private:
  struct Link {
    int other, order;
  };

  int local(int atom) const {
    return int(std::lower_bound(atoms_.begin(), atoms_.end(), atom) - atoms_.begin());
  }

  bool are_bonded(int a, int b, int order) const {
    for (const Link& link : neighbours_[std::size_t(a)])
      if (link.other == b) return link.order == order;
    return false;
  }

  bool fits(int atom, int as) const {
    if (taken_[std::size_t(as)] ||
        colour_[std::size_t(atoms_[std::size_t(atom)])] !=
            colour_[std::size_t(atoms_[std::size_t(as)])] ||
        neighbours_[std::size_t(atom)].size() != neighbours_[std::size_t(as)].size())
      return false;
    for (const Link& link : neighbours_[std::size_t(atom)]) {
      const int there = image_[std::size_t(link.other)];
      if (there >= 0 && !are_bonded(as, there, link.order)) return false;
    }
    return true;
  }

  void extend(std::size_t depth) {
    if (found.size() >= most_symmetries) return;
    if (depth == order_.size()) {
      if (keeps_hands()) found.push_back(image_);
      return;
    }
    const int atom = order_[depth];
    for (int as = 0; as < int(atoms_.size()); ++as) {
      if (!fits(atom, as)) continue;
      image_[std::size_t(atom)] = as;
      taken_[std::size_t(as)] = 1;
      extend(depth + 1);
      image_[std::size_t(atom)] = -1;
      taken_[std::size_t(as)] = 0;
    }
  }

  bool is_in(int atom) const { return std::binary_search(atoms_.begin(), atoms_.end(), atom); }

  /// The neighbours of a centre, those beside the ring system by their surroundings; empty where
  /// two of them are alike, so that it has no hand.
  std::vector<int> arms(int centre) const {
    std::vector<int> ring, beside;
    for (const auto& [other, bond] : molecule_.neighbours(centre))
      (is_in(other) ? ring : beside).push_back(other);
    std::sort(ring.begin(), ring.end());
    std::sort(beside.begin(), beside.end(),
              [this](int a, int b) { return colour_[std::size_t(a)] < colour_[std::size_t(b)]; });
    for (std::size_t k = 1; k < beside.size(); ++k)
      if (colour_[std::size_t(beside[k])] == colour_[std::size_t(beside[k - 1])]) return {};
    ring.insert(ring.end(), beside.begin(), beside.end());
    return ring;
  }

  double hand(const std::vector<int>& four) const {
    const auto& x = molecule_.positions();
    return signed_volume(x[std::size_t(four[0])], x[std::size_t(four[1])], x[std::size_t(four[2])],
                         x[std::size_t(four[3])]);
  }

  bool keeps_hands() const {
    for (std::size_t k = 0; k < atoms_.size(); ++k) {
      if (molecule_.neighbours(atoms_[k]).size() != 4) continue;
      const std::vector<int> here = arms(atoms_[k]);
      const std::vector<int> there = arms(atoms_[std::size_t(image_[k])]);
      if (here.size() != 4 || there.size() != 4) continue;
      std::vector<int> mapped = there;
      for (std::size_t j = 0; j < 4 && is_in(here[j]); ++j)
        mapped[j] = atoms_[std::size_t(image_[std::size_t(local(here[j]))])];
      if (hand(here) * hand(mapped) < 0) return false;
    }
    return true;
  }

  const Molecule& molecule_;
  const std::vector<int>& atoms_;
  std::vector<std::uint64_t> colour_;
  std::vector<std::vector<Link>> neighbours_;
  std::vector<int> order_, image_;
  std::vector<unsigned char> taken_;
};

}  // namespace

double torsion_of(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 ab = b - a, bc = c - b, cd = d - c;
  const Vec3 m = ab.cross(bc), n = bc.cross(cd);
  return std::atan2(bc.norm() * ab.dot(n), m.dot(n));
}

TermValue value_of(const TorsionTerm& term, double phi) {
  TermValue value;
  for (int k = 1; k <= 6; ++k) {
    const double amplitude = term.amplitude[std::size_t(k - 1)];
    if (amplitude == 0) continue;
    const double sign = term.sign[std::size_t(k - 1)];
    value.energy += amplitude * (1 + sign * std::cos(k * phi));
    value.slope -= amplitude * sign * k * std::sin(k * phi);
  }
  return value;
}

TorsionScore::TorsionScore(std::vector<ShiftedTerm> terms) : terms_(std::move(terms)) {
  std::map<std::pair<int, int>, int> about;
  const auto axis = [](const TorsionTerm& term) {
    return std::pair(std::min(term.b, term.c), std::max(term.b, term.c));
  };
  for (const auto& [term, shift] : terms_) ++about[axis(term)];
  for (const auto& [term, shift] : terms_) {
    double curvature = 0, amplitude = 0;
    for (int k = 1; k <= 6; ++k) {
      const double size = std::abs(term.amplitude[std::size_t(k - 1)]);
      amplitude += size;
      curvature += size * k * k;
    }
    curvature_.push_back(std::max(curvature, 1e-6));
    share_.push_back(amplitude / (amplitude + weak) / about[axis(term)]);
  }
}

double TorsionScore::energy(std::span<const Vec3> positions) const {
  const auto x = [&](int atom) -> const Vec3& { return positions[std::size_t(atom)]; };
  double sum = 0;
  for (const auto& [t, shift] : terms_)
    sum += value_of(t, torsion_of(x(t.a), x(t.b), x(t.c), x(t.d)) + shift).energy;
  return sum;
}

void TorsionScore::lead(std::span<const Vec3> positions, std::span<Vec3> displacements) const {
  const auto x = [&](int atom) -> const Vec3& { return positions[std::size_t(atom)]; };
  for (std::size_t k = 0; k < terms_.size(); ++k) {
    const TorsionTerm& t = terms_[k].term;
    const Vec3 ab = x(t.b) - x(t.a), bc = x(t.c) - x(t.b), cd = x(t.d) - x(t.c);
    const Vec3 m = ab.cross(bc), n = bc.cross(cd);
    const double mm = m.squaredNorm(), nn = n.squaredNorm(), length = bc.norm();
    if (!(mm > 1e-10) || !(nn > 1e-10)) continue;
    const double phi = std::atan2(length * ab.dot(n), m.dot(n)) + terms_[k].shift;
    const double turn = std::clamp(-value_of(t, phi).slope / curvature_[k], -furthest, furthest);
    // of the torsion's gradient (Blondel and Karplus, J. Comput. Chem. 17, 1132, 1996)
    const Vec3 at_a = -length / mm * m, at_d = length / nn * n;
    const double p = -ab.dot(bc) / (length * length), q = -cd.dot(bc) / (length * length);
    const Vec3 at_b = -(1 - p) * at_a - q * at_d, at_c = -p * at_a - (1 - q) * at_d;
    const double square =
        at_a.squaredNorm() + at_b.squaredNorm() + at_c.squaredNorm() + at_d.squaredNorm();
    const double scale = share_[k] * turn / square;
    displacements[std::size_t(t.a)] += scale * at_a;
    displacements[std::size_t(t.b)] += scale * at_b;
    displacements[std::size_t(t.c)] += scale * at_c;
    displacements[std::size_t(t.d)] += scale * at_d;
  }
}

RingTorsions::RingTorsions(const Molecule& molecule, const RingSystem& system,
                           const PliantRings& pliant) {
  const auto local = [&](int atom) {
    const auto at = std::lower_bound(system.atoms.begin(), system.atoms.end(), atom);
    return at != system.atoms.end() && *at == atom ? int(at - system.atoms.begin()) : -1;
  };
  for (const int bond : system.bonds) {
    if (!pliant.turns(bond)) continue;
    const auto [b, c, order] = molecule.bonds()[std::size_t(bond)];
    for (const auto& [a, ab] : molecule.neighbours(b))
      for (const auto& [d, cd] : molecule.neighbours(c))
        if (a != c && d != b && a != d && pliant.in_ring(ab) && pliant.in_ring(cd))
          torsions_.push_back({local(a), local(b), local(c), local(d)});
  }
  find_symmetries(molecule, system);
}

void RingTorsions::find_symmetries(const Molecule& molecule, const RingSystem& system) {
  std::map<std::array<int, 4>, int> number;
  for (std::size_t k = 0; k < torsions_.size(); ++k) {
    const auto [a, b, c, d] = torsions_[k];
    number[{a, b, c, d}] = number[{d, c, b, a}] = int(k);
  }
  std::vector<int> same(torsions_.size());
  for (std::size_t k = 0; k < same.size(); ++k) same[k] = int(k);
  images_.push_back(same);
  for (const std::vector<int>& image : Automorphisms(molecule, system).found) {
    std::vector<int> of(torsions_.size(), -1);
    for (std::size_t k = 0; k < of.size(); ++k) {
      std::array<int, 4> mapped;
      for (std::size_t j = 0; j < 4; ++j) mapped[j] = image[std::size_t(torsions_[k][j])];
      if (const auto at = number.find(mapped); at != number.end()) of[k] = at->second;
    }
    if (std::find(of.begin(), of.end(), -1) != of.end()) continue;
    if (std::find(images_.begin(), images_.end(), of) == images_.end()) images_.push_back(of);
  }
}

std::vector<float> RingTorsions::measure(std::span<const Vec3> positions) const {
  std::vector<float> angles;
  angles.reserve(torsions_.size());
  const auto x = [&](int atom) -> const Vec3& { return positions[std::size_t(atom)]; };
  for (const auto& [a, b, c, d] : torsions_)
    angles.push_back(float(torsion_of(x(a), x(b), x(c), x(d))));
  return angles;
}

double RingTorsions::distance(std::span<const float> one, std::span<const float> other) const {
  if (torsions_.empty()) return 0;
  constexpr float turn = float(2 * std::numbers::pi);
  float least = std::numeric_limits<float>::infinity();
  for (const std::vector<int>& image : images_) {
    float sum = 0;
    for (std::size_t k = 0; k < image.size(); ++k) {
      float difference = std::abs(one[std::size_t(image[k])] - other[k]);
      difference = std::min(difference, turn - difference);
      sum += difference * difference;
    }
    least = std::min(least, sum);
  }
  return std::sqrt(double(least) / double(torsions_.size()));
}

}  // namespace ragdoll
