#include "molecules.h"

#include <Eigen/Geometry>  // AngleAxisd
#include <cmath>           // cos, sin, sqrt
#include <numbers>         // pi

namespace ragdoll::examples {
namespace {

constexpr double degree = std::numbers::pi / 180;

double mass_of(int element) {
  switch (element) {
    case 1:
      return 1.008;
    case 6:
      return 12.011;
    case 7:
      return 14.007;
    case 8:
      return 15.999;
    default:
      return 2.0 * element;
  }
}

Vec3 in_plane(double length, double angle_degree) {
  return length * Vec3(std::cos(angle_degree * degree), std::sin(angle_degree * degree), 0);
}

/// Atoms and bonds one after the other.
struct Sketch {
  std::vector<Atom> atoms;
  std::vector<Bond> bonds;
  std::vector<Vec3> x;

  int add(int element, const Vec3& position) {
    atoms.push_back({element, 0, mass_of(element), ""});
    x.push_back(position);
    return int(atoms.size()) - 1;
  }

  void bond(int a, int b, BondOrder order = BondOrder::single) { bonds.push_back({a, b, order}); }

  /// Three hydrogens on a carbon, tetrahedral about the direction away from its one neighbour.
  void add_methyl_hydrogens(int carbon, int neighbour, double turn_degree) {
    const Vec3 axis = (at(carbon) - at(neighbour)).normalized();
    const Vec3 side = axis.unitOrthogonal(), other = axis.cross(side);
    for (int k = 0; k < 3; ++k) {
      const double turn = (turn_degree + 120 * k) * degree;
      const Vec3 out = std::cos(turn) * side + std::sin(turn) * other;
      const int hydrogen = add(1, at(carbon) + 0.109 * (axis / 3 + std::sqrt(8.0) / 3 * out));
      bond(carbon, hydrogen);
    }
  }

  /// Two hydrogens on a carbon between two neighbours.
  void add_methylene_hydrogens(int carbon, int one, int two) {
    const Vec3 u = (at(one) - at(carbon)).normalized(), v = (at(two) - at(carbon)).normalized();
    const Vec3 out = -(u + v).normalized(), across = u.cross(v).normalized();
    for (const int side : {1, -1}) {
      const Vec3 direction =
          std::cos(54.75 * degree) * out + side * std::sin(54.75 * degree) * across;
      const int hydrogen = add(1, at(carbon) + 0.109 * direction);
      bond(carbon, hydrogen);
    }
  }

  const Vec3& at(int atom) const { return x[std::size_t(atom)]; }

  Molecule molecule() const { return Molecule(atoms, bonds, x); }
};

}  // namespace

Molecule methane_like(int h1, int h2, int h3, int h4) {
  const double arm = 0.109 / std::sqrt(3.0);
  Sketch sketch;
  sketch.add(6, Vec3::Zero());
  sketch.add(h1, arm * Vec3(1, 1, 1));
  sketch.add(h2, arm * Vec3(-1, -1, 1));
  sketch.add(h3, arm * Vec3(-1, 1, -1));
  sketch.add(h4, arm * Vec3(1, -1, -1));
  for (int k = 1; k <= 4; ++k) sketch.bond(0, k);
  return sketch.molecule();
}

Molecule ethane() {
  Sketch sketch;
  sketch.add(6, {0, 0, 0});
  sketch.add(6, {0.154, 0, 0});
  sketch.bond(0, 1);
  sketch.add_methyl_hydrogens(0, 1, 0);
  // seen from the other end the side vector is another: turn until the torsions are staggered
  sketch.add_methyl_hydrogens(1, 0, 0);
  const auto torsion = [&] {
    const Vec3 axis = Vec3::UnitX();
    const Vec3 u = sketch.at(2).cross(axis), v = (sketch.at(5) - sketch.at(1)).cross(axis);
    return std::atan2(u.cross(v).dot(axis), u.dot(v));
  };
  const Eigen::AngleAxisd turn(60 * degree - torsion(), Vec3::UnitX());
  for (std::size_t k = 5; k < 8; ++k) sketch.x[k] = turn * sketch.x[k];
  return sketch.molecule();
}

Molecule ammonia() {
  Sketch sketch;
  sketch.add(7, {0, 0, 0});
  for (int k = 0; k < 3; ++k) {
    sketch.add(1, in_plane(0.0937, 120 * k) + Vec3(0, 0, -0.038));
    sketch.bond(0, k + 1);
  }
  return sketch.molecule();
}

Molecule formamide() {
  Sketch sketch;
  const int c = sketch.add(6, {0, 0, 0});
  const int o = sketch.add(8, in_plane(0.122, 120));
  const int n = sketch.add(7, {0.135, 0, 0});
  const int h = sketch.add(1, in_plane(0.110, 240));
  const int h1 = sketch.add(1, sketch.at(n) + in_plane(0.101, 60));
  const int h2 = sketch.add(1, sketch.at(n) + in_plane(0.101, -60));
  sketch.bond(c, o, BondOrder::double_bond);
  sketch.bond(c, n);
  sketch.bond(c, h);
  sketch.bond(n, h1);
  sketch.bond(n, h2);
  return sketch.molecule();
}

Molecule methylacetamide(double omega_degree) {
  const Eigen::AngleAxisd turn((omega_degree - 180) * degree, Vec3::UnitX());
  Sketch sketch;
  const int c = sketch.add(6, {0, 0, 0});
  const int o = sketch.add(8, in_plane(0.123, 120));
  const int n = sketch.add(7, {0.133, 0, 0});
  const int c1 = sketch.add(6, in_plane(0.151, 240));
  const int c2 = sketch.add(6, sketch.at(n) + turn * in_plane(0.146, 60));
  const int h = sketch.add(1, sketch.at(n) + turn * in_plane(0.101, -60));
  sketch.bond(c, o, BondOrder::double_bond);
  sketch.bond(c, n);
  sketch.bond(c, c1);
  sketch.bond(n, c2);
  sketch.bond(n, h);
  sketch.add_methyl_hydrogens(c1, c, 20);
  sketch.add_methyl_hydrogens(c2, n, 50);
  return sketch.molecule();
}

Molecule benzene() {
  Sketch sketch;
  for (int k = 0; k < 6; ++k) sketch.add(6, in_plane(0.139, 60 * k));
  for (int k = 0; k < 6; ++k) sketch.add(1, in_plane(0.248, 60 * k));
  for (int k = 0; k < 6; ++k) sketch.bond(k, (k + 1) % 6, BondOrder::aromatic);
  for (int k = 0; k < 6; ++k) sketch.bond(k, k + 6);
  return sketch.molecule();
}

Molecule acetylene() {
  Sketch sketch;
  sketch.add(6, {0, 0, 0});
  sketch.add(6, {0.120, 0, 0});
  sketch.add(1, {-0.106, 0, 0});
  sketch.add(1, {0.226, 0, 0});
  sketch.bond(0, 1, BondOrder::triple);
  sketch.bond(0, 2);
  sketch.bond(1, 3);
  return sketch.molecule();
}

Molecule allene() {
  Sketch sketch;
  sketch.add(6, {-0.131, 0, 0});
  sketch.add(6, {0, 0, 0});
  sketch.add(6, {0.131, 0, 0});
  sketch.add(1, sketch.at(0) + in_plane(0.109, 120));
  sketch.add(1, sketch.at(0) + in_plane(0.109, 240));
  sketch.add(1, {0.131 + 0.0545, 0, 0.0944});
  sketch.add(1, {0.131 + 0.0545, 0, -0.0944});
  sketch.bond(0, 1, BondOrder::double_bond);
  sketch.bond(1, 2, BondOrder::double_bond);
  sketch.bond(0, 3);
  sketch.bond(0, 4);
  sketch.bond(2, 5);
  sketch.bond(2, 6);
  return sketch.molecule();
}

Molecule cyclopentane_ring() {
  Sketch sketch;
  for (int k = 0; k < 5; ++k) sketch.add(6, in_plane(0.131, 72 * k));
  sketch.x[0] += Vec3(-0.02, 0, 0.065);
  for (int k = 0; k < 5; ++k) sketch.bond(k, (k + 1) % 5);
  return sketch.molecule();
}

Molecule heptane() {
  // a zigzag whose halves are turned about its fourth bond
  Sketch sketch;
  const Eigen::AngleAxisd turn(65 * degree, Vec3::UnitX());
  for (int k = 0; k < 7; ++k) {
    const Vec3 zigzag(0.1257 * k, k % 2 == 0 ? 0 : 0.0889, 0);
    const Vec3 pivot(0.1257 * 3, 0.0889, 0);
    sketch.add(6, k <= 3 ? zigzag : Vec3(pivot + turn * (zigzag - pivot)));
    if (k > 0) sketch.bond(k - 1, k);
  }
  sketch.add_methyl_hydrogens(0, 1, 10);
  for (int k = 1; k < 6; ++k) sketch.add_methylene_hydrogens(k, k - 1, k + 1);
  sketch.add_methyl_hydrogens(6, 5, 30);
  return sketch.molecule();
}

Molecule loose_atoms(const std::vector<int>& elements, const std::vector<Vec3>& positions) {
  Sketch sketch;
  for (std::size_t k = 0; k < elements.size(); ++k) sketch.add(elements[k], positions[k]);
  return sketch.molecule();
}

}  // namespace ragdoll::examples
