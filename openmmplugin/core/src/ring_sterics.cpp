#include "ring_sterics.h"

#include <algorithm>  // max
#include <cmath>      // sqrt

namespace ragdoll {
namespace {

struct Size {
  double distance;  ///< of two alike, where the potential is least, nm
  double depth;     ///< kJ/mol
};

Size size_of(int element) {
  switch (element) {
    case 1:
      return {0.2886, 0.184};
    case 6:
      return {0.3851, 0.439};
    case 7:
      return {0.3660, 0.289};
    case 8:
      return {0.3500, 0.251};
    case 9:
      return {0.3364, 0.209};
    case 15:
      return {0.4147, 1.276};
    case 16:
      return {0.4035, 1.146};
    case 17:
      return {0.3947, 0.950};
    case 35:
      return {0.4189, 1.050};
    default:
      return {0.4000, 0.600};
  }
}

/// Atoms nearer than this share of the distance where it ends repel each other no more.
constexpr double hardest = 0.6;

/// Of atoms three bonds apart.
constexpr double three_bonds_share = 0.5;

}  // namespace

RingSterics::RingSterics(const Molecule& molecule, std::span<const int> atoms) {
  std::vector<int> bonds(molecule.atoms().size(), -1), found;
  for (std::size_t k = 0; k < atoms.size(); ++k) {
    found.assign(1, atoms[k]);
    bonds[std::size_t(atoms[k])] = 0;
    for (std::size_t next = 0; next < found.size(); ++next) {
      const int apart = bonds[std::size_t(found[next])];
      if (apart == 3) break;
      for (const auto& [other, bond] : molecule.neighbours(found[next]))
        if (bonds[std::size_t(other)] < 0) {
          bonds[std::size_t(other)] = apart + 1;
          found.push_back(other);
        }
    }
    const Size one = size_of(molecule.atoms()[std::size_t(atoms[k])].element);
    for (std::size_t j = k + 1; j < atoms.size(); ++j) {
      const int apart = bonds[std::size_t(atoms[j])];
      if (apart >= 0 && apart < 3) continue;
      const Size other = size_of(molecule.atoms()[std::size_t(atoms[j])].element);
      const double share = apart == 3 ? three_bonds_share : 1;
      pairs_.push_back({int(k), int(j), one.distance * other.distance,
                        share * std::sqrt(one.depth * other.depth)});
    }
    for (const int atom : found) bonds[std::size_t(atom)] = -1;
  }
}

double RingSterics::energy(std::span<const Vec3> positions) const {
  double sum = 0;
  for (const Pair& pair : pairs_) {
    const double r2 =
        (positions[std::size_t(pair.q)] - positions[std::size_t(pair.p)]).squaredNorm();
    if (r2 >= pair.square) continue;
    const double ratio = pair.square / std::max(r2, hardest * hardest * pair.square);
    const double s = ratio * ratio * ratio;
    sum += pair.depth * (s - 1) * (s - 1);
  }
  return sum;
}

void RingSterics::push(std::span<const Vec3> positions, double step,
                       std::span<Vec3> displacements) const {
  for (const Pair& pair : pairs_) {
    const Vec3 d = positions[std::size_t(pair.q)] - positions[std::size_t(pair.p)];
    const double r2 = d.squaredNorm();
    if (r2 >= pair.square) continue;
    const double least = std::max(r2, hardest * hardest * pair.square);
    const double ratio = pair.square / least, s = ratio * ratio * ratio;
    const Vec3 move = step * 12 * pair.depth * (s - 1) * s / least * d;
    displacements[std::size_t(pair.q)] += move;
    displacements[std::size_t(pair.p)] -= move;
  }
}

}  // namespace ragdoll
