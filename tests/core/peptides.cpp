#include "peptides.h"

#include <cmath>    // atan2, cos, sin
#include <numbers>  // pi

namespace ragdoll::examples {
namespace {

constexpr double degree = std::numbers::pi / 180;

/// The place at `length` from c, with the angle b-c-d and the torsion a-b-c-d.
Vec3 place(const Vec3& a, const Vec3& b, const Vec3& c, double length, double angle,
           double torsion) {
  const Vec3 bc = (c - b).normalized(), n = (b - a).cross(bc).normalized(), m = n.cross(bc);
  const double t = torsion * degree, w = angle * degree;
  return c + length * (-std::cos(w) * bc + std::sin(w) * (std::cos(t) * m + std::sin(t) * n));
}

double torsion(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 ab = b - a, bc = c - b, n = bc.cross(d - c);
  return std::atan2(bc.norm() * ab.dot(n), ab.cross(bc).dot(n)) / degree;
}

}  // namespace

Molecule alanines(const std::vector<PhiPsi>& torsions, bool mirrored) {
  std::vector<Atom> atoms = {{6, 0, 12, "CH3 ACE"}, {6, 0, 12, "C ACE"}, {8, 0, 16, "O ACE"}};
  std::vector<Bond> bonds = {{0, 1, BondOrder::single}, {1, 2, BondOrder::double_bond}};
  std::vector<Vec3> x = {{0, 0, 0}, {0.152, 0, 0}, {0.2184, 0.1034, 0}};
  int alpha = 0, carbon = 1, oxygen = 2;  // of the residue before
  const auto bond = [&](int a, int b) { bonds.push_back({a, b, BondOrder::single}); };
  const auto at = [&](int i) -> const Vec3& { return x[std::size_t(i)]; };
  for (std::size_t k = 0; k < torsions.size(); ++k) {
    const auto [phi, psi] = torsions[k];
    const int n = int(atoms.size()), ca = n + 1, c = n + 2, o = n + 3, cb = n + 4;
    const std::string residue = " ALA" + std::to_string(k + 1);
    for (const auto& [element, name] : {std::pair(7, "N"), std::pair(6, "CA"), std::pair(6, "C"),
                                        std::pair(8, "O"), std::pair(6, "CB")})
      atoms.push_back({element, 0, 12, name + residue});
    x.push_back(
        k == 0 ? place(at(oxygen), at(alpha), at(carbon), 0.1336, 117.2, 180)
               : place(at(carbon - 2), at(alpha), at(carbon), 0.1336, 117.2, torsions[k - 1].psi));
    x.push_back(place(at(alpha), at(carbon), at(n), 0.1459, 121.7, 180));
    x.push_back(place(at(carbon), at(n), at(ca), 0.1525, 111.0, phi));
    x.push_back(place(at(n), at(ca), at(c), 0.1229, 120.1, psi + 180));
    x.push_back(place(at(carbon), at(n), at(ca), 0.153, 110.4, phi - 122.6));
    bond(carbon, n);
    bond(n, ca);
    bond(ca, c);
    bonds.push_back({c, o, BondOrder::double_bond});
    bond(ca, cb);
    alpha = ca;
    carbon = c;
    oxygen = o;
  }
  const int n = int(atoms.size());
  atoms.push_back({7, 0, 14, "N NME"});
  atoms.push_back({6, 0, 15, "CH3 NME"});
  x.push_back(place(at(carbon - 2), at(alpha), at(carbon), 0.1336, 117.2, torsions.back().psi));
  x.push_back(place(at(alpha), at(carbon), at(n), 0.1459, 121.7, 180));
  bond(carbon, n);
  bond(n, n + 1);
  if (mirrored)
    for (Vec3& point : x) point.z() = -point.z();
  return Molecule(std::move(atoms), std::move(bonds), std::move(x));
}

PhiPsi torsions_of(const std::vector<Vec3>& x, int alanine) {
  const auto at = [&](int i) -> const Vec3& { return x[std::size_t(i)]; };
  const int n = 3 + 5 * alanine, before = alanine == 0 ? 1 : n - 3, after = n + 5;
  return {torsion(at(before), at(n), at(n + 1), at(n + 2)),
          torsion(at(n), at(n + 1), at(n + 2), at(after))};
}

}  // namespace ragdoll::examples
