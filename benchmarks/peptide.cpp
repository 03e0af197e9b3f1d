#include "peptide.h"

#include <cmath>    // sin, cos
#include <numbers>  // pi
#include <utility>  // move

#include "ragdoll/random.h"  // Random

namespace benchmark {
namespace {

using ragdoll::Bond;
using ragdoll::BondOrder;
using ragdoll::Vec3;

constexpr double degree = std::numbers::pi / 180;
enum Element { carbon = 6, nitrogen = 7, oxygen = 8, sulfur = 16 };

/// Adds an atom by its bond length, angle and torsion to atoms that are there.
class Chain {
 public:
  explicit Chain(Peptide& peptide) : peptide_(peptide) {}

  int count() const { return int(peptide_.atoms.size()); }

  int place(Element element, const Vec3& position) {
    const double mass = element == carbon     ? 12.011
                        : element == nitrogen ? 14.007
                        : element == oxygen   ? 15.999
                                              : 32.06;
    peptide_.atoms.push_back({element, 0, mass});
    peptide_.positions.push_back(position);
    return count() - 1;
  }

  void bond(int a, int b, BondOrder order = BondOrder::single) {
    peptide_.bonds.push_back({a, b, order});
  }

  /// Bonded to c, at an angle with b-c, turned by `torsion` from a. nm, degrees
  int add(Element element, int a, int b, int c, double length, double angle, double torsion,
          BondOrder order = BondOrder::single) {
    const Vec3 bc = (x(c) - x(b)).normalized();
    const Vec3 n = (x(b) - x(a)).cross(bc).normalized();
    const Vec3 m = n.cross(bc);
    const double s = std::sin(angle * degree);
    const Vec3 direction = -std::cos(angle * degree) * bc + s * std::cos(torsion * degree) * m +
                           s * std::sin(torsion * degree) * n;
    const int atom = place(element, x(c) + length * direction);
    bond(c, atom, order);
    return atom;
  }

 private:
  const Vec3& x(int atom) const { return peptide_.positions[std::size_t(atom)]; }

  Peptide& peptide_;
};

/// Six-membered aromatic ring on c; a and b say how it is turned.
void add_ring(Chain& chain, int a, int b, int c, double torsion, bool hydroxyl) {
  constexpr auto aromatic = BondOrder::aromatic;
  const int g = chain.add(carbon, a, b, c, 0.151, 114, torsion);
  const int d1 = chain.add(carbon, b, c, g, 0.139, 120, 90, aromatic);
  const int d2 = chain.add(carbon, b, c, g, 0.139, 120, -90, aromatic);
  const int e1 = chain.add(carbon, c, g, d1, 0.139, 120, 180, aromatic);
  const int e2 = chain.add(carbon, c, g, d2, 0.139, 120, 180, aromatic);
  const int z = chain.add(carbon, g, d1, e1, 0.139, 120, 0, aromatic);
  chain.bond(e2, z, aromatic);
  if (hydroxyl) chain.add(oxygen, d1, e1, z, 0.136, 120, 180);
}

/// Atoms beyond the alpha carbon.
void add_side_chain(Chain& chain, int kind, int n, int c, int alpha, double turn) {
  if (kind == 0) return;  // glycine
  // from the carbonyl, so that every residue is of the same hand
  const int beta = chain.add(carbon, c, n, alpha, 0.153, 110.5, -122.5);
  const auto on_beta = [&](Element element, double length, double torsion) {
    return chain.add(element, n, alpha, beta, length, 111, torsion);
  };
  if (kind == 2) on_beta(oxygen, 0.142, turn);
  if (kind == 3) {
    on_beta(carbon, 0.152, turn);
    on_beta(carbon, 0.152, turn + 120);
  }
  if (kind == 4) {
    const int gamma = on_beta(carbon, 0.153, turn);
    chain.add(carbon, alpha, beta, gamma, 0.152, 110, 60);
    chain.add(carbon, alpha, beta, gamma, 0.152, 110, 180);
  }
  if (kind == 5) {
    const int gamma = on_beta(carbon, 0.152, turn);
    const int delta = chain.add(carbon, alpha, beta, gamma, 0.152, 112, 180);
    const int epsilon = chain.add(carbon, beta, gamma, delta, 0.152, 112, 180);
    chain.add(nitrogen, gamma, delta, epsilon, 0.149, 112, 180);
  }
  if (kind == 6) {
    const int gamma = on_beta(carbon, 0.152, turn);
    chain.add(oxygen, alpha, beta, gamma, 0.123, 121, 0, BondOrder::double_bond);
    chain.add(nitrogen, alpha, beta, gamma, 0.133, 117, 180);
  }
  if (kind == 7 || kind == 8) add_ring(chain, n, alpha, beta, turn, kind == 8);
  if (kind == 9) {
    const int gamma = on_beta(carbon, 0.153, turn);
    const int delta = chain.add(sulfur, alpha, beta, gamma, 0.181, 113, 180);
    chain.add(carbon, beta, gamma, delta, 0.179, 101, 180);
  }
}

}  // namespace

Peptide make_peptide(int atoms) {
  Peptide peptide;
  Chain chain(peptide);
  ragdoll::Random random(11, ragdoll::RandomStream::generate, 0);
  int n = chain.place(nitrogen, {0, 0, 0});
  int alpha = chain.place(carbon, {0.146, 0, 0});
  chain.bond(n, alpha);
  int c = chain.place(carbon, {0.1965, 0.1438, 0});
  chain.bond(alpha, c);
  for (;;) {
    const bool helix = random.uniform() < 0.85;
    const double phi = helix ? -57 : -150 + 90 * random.uniform();
    const double psi = helix ? -47 : 60 + 110 * random.uniform();
    const double turn = -60 + 120 * double(random.below(3)) + 10 * random.uniform();
    add_side_chain(chain, int(random.below(10)), n, c, alpha, turn);
    chain.add(oxygen, n, alpha, c, 0.123, 120.5, psi + 180, BondOrder::double_bond);
    if (chain.count() >= atoms) return peptide;
    const int next_n = chain.add(nitrogen, n, alpha, c, 0.133, 116.5, psi);
    const int next_alpha = chain.add(carbon, alpha, c, next_n, 0.146, 121.5, 180);
    c = chain.add(carbon, c, next_n, next_alpha, 0.1525, 111, phi);
    n = next_n;
    alpha = next_alpha;
  }
}

ragdoll::Molecule molecule_of(Peptide peptide) {
  return {std::move(peptide.atoms), std::move(peptide.bonds), std::move(peptide.positions)};
}

}  // namespace benchmark
