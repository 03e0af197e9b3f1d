#include "torsion_table.h"

#include <algorithm>  // max, min_element
#include <cmath>      // exp, cos, floor
#include <numbers>    // pi

#include "chemistry_rules.h"  // PlanarUnits
#include "ring_torsions.h"    // torsion_of

namespace ragdoll {
namespace {

constexpr double degree = std::numbers::pi / 180;

enum class Kind { linear, planar, tetrahedral };

Kind kind_of(const Molecule& molecule, const PlanarUnits& planar, int atom) {
  const auto& around = molecule.neighbours(atom);
  const int element = molecule.atoms()[std::size_t(atom)].element;
  if (around.size() == 2) {
    int doubles = 0;
    for (const auto& [other, bond] : around) {
      const BondOrder order = molecule.bonds()[std::size_t(bond)].order;
      if (order == BondOrder::triple) return Kind::linear;
      doubles += order == BondOrder::double_bond;
    }
    if (doubles == 2) return Kind::linear;
    // O, N and S beside something flat take part in it
    if (element != 6)
      for (const auto& [other, bond] : around)
        if (planar.planar_atom(other)) return Kind::planar;
  }
  return planar.planar_atom(atom) ? Kind::planar : Kind::tetrahedral;
}

bool has_aromatic_bond(const Molecule& molecule, int atom) {
  for (const auto& [other, bond] : molecule.neighbours(atom))
    if (molecule.bonds()[std::size_t(bond)].order == BondOrder::aromatic) return true;
  return false;
}

/// The O or S of a carbonyl, or -1.
int carbonyl_end(const Molecule& molecule, int carbon) {
  if (molecule.atoms()[std::size_t(carbon)].element != 6) return -1;
  for (const auto& [other, bond] : molecule.neighbours(carbon)) {
    const int element = molecule.atoms()[std::size_t(other)].element;
    if (molecule.bonds()[std::size_t(bond)].order == BondOrder::double_bond &&
        (element == 8 || element == 16))
      return other;
  }
  return -1;
}

int heavy_neighbours(const Molecule& molecule, int atom) {
  int heavy = 0;
  for (const auto& [other, bond] : molecule.neighbours(atom))
    heavy += molecule.atoms()[std::size_t(other)].element != 1;
  return heavy;
}

/// Whether the side of the bond belongs to the configuration: amides with one hydrogen, esters.
bool keeps_side(const Molecule& molecule, const Part& part) {
  for (const auto& [carbon, end] :
       {std::pair(part.inner, part.outer), std::pair(part.outer, part.inner)}) {
    if (carbonyl_end(molecule, carbon) < 0) continue;
    const int element = molecule.atoms()[std::size_t(end)].element;
    const std::size_t around = molecule.neighbours(end).size();
    const int heavy = heavy_neighbours(molecule, end);
    if (element == 7 && around == 3 && heavy == 2) return true;
    if ((element == 8 || element == 16) && around == 2 && heavy == 2) return true;
  }
  return false;
}

double start_torsion(const Molecule& molecule, int a, int b, int c, int d) {
  const auto x = [&](int atom) -> const Vec3& { return molecule.positions()[std::size_t(atom)]; };
  return torsion_of(x(a), x(b), x(c), x(d));
}

}  // namespace

TorsionTable::TorsionTable(std::span<const double, bins> energies,
                           std::span<const bool, bins> allowed, double temperature) {
  double least = 1e300;
  bool any = false;
  for (std::size_t k = 0; k < bins; ++k) any = any || allowed[k];
  const auto may = [&](std::size_t k) { return allowed[k] || !any; };
  for (std::size_t k = 0; k < bins; ++k)
    if (may(k)) least = std::min(least, energies[k]);
  std::array<double, bins> weight;
  double sum = 0;
  for (std::size_t k = 0; k < bins; ++k) {
    energy_[k] = float(energies[k] - least);
    weight[k] = may(k) ? std::exp(-(energies[k] - least) / temperature) : 0;
    sum += weight[k];
  }
  std::array<std::size_t, bins> small, large;
  std::size_t nsmall = 0, nlarge = 0;
  for (std::size_t k = 0; k < bins; ++k) {
    weight[k] *= bins / sum;
    (weight[k] < 1 ? small[nsmall++] : large[nlarge++]) = k;
    threshold_[k] = ~std::uint32_t{0};
    alias_[k] = std::uint16_t(k);
  }
  while (nsmall > 0 && nlarge > 0) {
    const std::size_t few = small[--nsmall], many = large[nlarge - 1];
    threshold_[few] = std::uint32_t(std::max(0.0, weight[few]) * 4294967295.0);
    alias_[few] = std::uint16_t(many);
    weight[many] -= 1 - weight[few];
    if (weight[many] < 1) {
      --nlarge;
      small[nsmall++] = many;
    }
  }
}

TorsionTerm rule_for(const Molecule& molecule, const Part& part) {
  TorsionTerm term{part.before, part.inner, part.outer, part.behind, {}, {}};
  const auto set = [&](int fold, double amplitude, int sign) {
    term.amplitude[std::size_t(fold - 1)] = amplitude;
    term.sign[std::size_t(fold - 1)] = sign;
  };
  const PlanarUnits planar(molecule);
  const Kind inner = kind_of(molecule, planar, part.inner);
  const Kind outer = kind_of(molecule, planar, part.outer);
  if (inner == Kind::linear || outer == Kind::linear) return term;
  const int one = molecule.atoms()[std::size_t(part.inner)].element;
  const int other = molecule.atoms()[std::size_t(part.outer)].element;
  const auto chalcogen = [](int element) { return element == 8 || element == 16 || element == 34; };
  const int o1 = carbonyl_end(molecule, part.inner), o2 = carbonyl_end(molecule, part.outer);
  if (inner == Kind::planar && outer == Kind::planar) {
    const bool ester = (o1 >= 0 && chalcogen(other)) || (o2 >= 0 && chalcogen(one));
    bool stiff = false;
    for (const auto& [neighbour, bond] : molecule.neighbours(part.inner))
      stiff = stiff || (neighbour == part.outer && planar.planar_bond(bond));
    if (ester) {
      if (o1 >= 0) term.a = o1;
      if (o2 >= 0) term.d = o2;
      set(1, 20, -1);
      set(2, 10, -1);
    } else if (stiff) {
      set(2, 40, -1);
    } else if (has_aromatic_bond(molecule, part.inner) && has_aromatic_bond(molecule, part.outer)) {
      set(4, 3, 1);
    } else {
      set(2, 8, -1);
    }
  } else if (inner == Kind::tetrahedral && outer == Kind::tetrahedral) {
    if (chalcogen(one) && chalcogen(other) && molecule.neighbours(part.inner).size() == 2 &&
        molecule.neighbours(part.outer).size() == 2)
      set(2, 15, 1);
    else
      set(3, 5, 1);
  } else {
    set(6, 1, 1);
  }
  return term;
}

std::vector<TorsionTable> torsion_tables(const Molecule& molecule, const PartTree& tree,
                                         std::span<const TorsionTerm> terms,
                                         const StericRule& sterics, double temperature) {
  std::vector<TorsionTable> tables;
  const std::vector<Part>& parts = tree.parts();
  tables.reserve(parts.size());
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const Part& part = parts[p];
    std::array<double, TorsionTable::bins> energies{};
    std::array<bool, TorsionTable::bins> allowed, clashes;
    allowed.fill(true);
    clashes.fill(false);
    if (part.parent >= 0) {
      std::vector<TorsionTerm> own;
      for (const TorsionTerm& t : terms)
        if ((t.b == part.inner && t.c == part.outer) || (t.c == part.inner && t.b == part.outer))
          own.push_back(t);
      if (own.empty()) own.push_back(rule_for(molecule, part));
      for (const TorsionTerm& t : own) {
        // d turns where c is the outer atom; else a does, the other way round: the same angle
        const double phase = start_torsion(molecule, t.a, t.b, t.c, t.d);
        for (int k = 0; k < TorsionTable::bins; ++k)
          energies[std::size_t(k)] += energy_of(t, phase + k * degree);
      }
      if (keeps_side(molecule, part)) {
        const double phase =
            start_torsion(molecule, part.before, part.inner, part.outer, part.behind);
        for (int k = 0; k < TorsionTable::bins; ++k)
          allowed[std::size_t(k)] = std::cos(phase + k * degree) * std::cos(phase) > 0;
      }
      // pairs across this bond alone
      const Part& parent = parts[std::size_t(part.parent)];
      if (parent.shapes.size() == 1 && part.shapes.size() == 1) {
        const auto x = [&](int atom) -> const Vec3& {
          return molecule.positions()[std::size_t(atom)];
        };
        const Vec3 axis = (x(part.outer) - x(part.inner)).normalized();
        for (const int i : parent.atoms)
          for (const int j : part.atoms) {
            const double reach = sterics.reach(i, j);
            if (!(reach > 0)) continue;
            const Vec3 u = x(i) - x(part.inner), v = x(j) - x(part.inner);
            const double du = u.dot(axis), dv = v.dot(axis);
            const Vec3 pu = u - du * axis, pv = v - dv * axis;
            const double along = (du - dv) * (du - dv) + pu.squaredNorm() + pv.squaredNorm();
            const double cosine = pu.dot(pv), sine = axis.dot(pv.cross(pu));
            for (int k = 0; k < TorsionTable::bins; ++k) {
              const double d2 =
                  along - 2 * (cosine * std::cos(k * degree) + sine * std::sin(k * degree));
              const double energy = StericRule::energy(d2, reach);
              energies[std::size_t(k)] += energy;
              clashes[std::size_t(k)] =
                  clashes[std::size_t(k)] || energy > StericRule::clash_energy;
            }
          }
      }
    }
    // where everything clashes, nothing is gained by leaving it out
    std::array<bool, TorsionTable::bins> both;
    bool any = false;
    for (std::size_t k = 0; k < both.size(); ++k) {
      both[k] = allowed[k] && !clashes[k];
      any = any || both[k];
    }
    if (any) allowed = both;
    tables.emplace_back(energies, allowed, temperature);
  }
  return tables;
}

}  // namespace ragdoll
