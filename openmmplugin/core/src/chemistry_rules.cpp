#include "chemistry_rules.h"

namespace ragdoll {
namespace {

constexpr int H = 1, B = 5, C = 6, N = 7, O = 8, F = 9, S = 16;

/// Bonds of an atom, counted by order.
struct BondCount {
  int doubles = 0, triples = 0, aromatics = 0, datives = 0;
};

BondCount bonds_of(const Molecule& molecule, int atom) {
  BondCount count;
  for (const auto& [other, bond] : molecule.neighbours(atom)) {
    switch (molecule.bonds()[std::size_t(bond)].order) {
      case BondOrder::double_bond:
        ++count.doubles;
        break;
      case BondOrder::triple:
        ++count.triples;
        break;
      case BondOrder::aromatic:
        ++count.aromatics;
        break;
      case BondOrder::dative:
        ++count.datives;
        break;
      default:
        break;
    }
  }
  return count;
}

/// A carbon with a double or aromatic bond to N, O or S: it conjugates with a neighbouring N.
bool draws_nitrogen_flat(const Molecule& molecule, int atom) {
  if (molecule.atoms()[std::size_t(atom)].element != C) return false;
  for (const auto& [other, bond] : molecule.neighbours(atom)) {
    const int element = molecule.atoms()[std::size_t(other)].element;
    const BondOrder order = molecule.bonds()[std::size_t(bond)].order;
    if ((order == BondOrder::double_bond || order == BondOrder::aromatic) &&
        (element == N || element == O || element == S))
      return true;
  }
  return false;
}

/// Boron with three bonds, and a carbocation.
bool has_empty_orbital(const Molecule& molecule, int atom, const BondCount& count) {
  const Atom& a = molecule.atoms()[std::size_t(atom)];
  return molecule.neighbours(atom).size() == 3 && count.datives == 0 &&
         ((a.element == B && a.formal_charge == 0) || (a.element == C && a.formal_charge == 1));
}

/// Atoms beside an aromatic end of a bond, as seen from it; `large` are those that carry more than
/// hydrogen there, a substituent or another ring.
struct Beside {
  std::vector<int> all, large;
};

Beside beside(const Molecule& molecule, int end, int other) {
  Beside found;
  for (const auto& [atom, bond] : molecule.neighbours(end)) {
    if (atom == other) continue;
    int heavy = 0;
    for (const auto& [further, further_bond] : molecule.neighbours(atom))
      heavy += further != end && molecule.atoms()[std::size_t(further)].element != H;
    found.all.push_back(atom);
    if (heavy >= 2) found.large.push_back(atom);
  }
  return found;
}

}  // namespace

std::optional<HinderedAxis> hindered_axis(const Molecule& molecule, int bond) {
  const Bond& axis = molecule.bonds()[std::size_t(bond)];
  if (axis.order != BondOrder::single || bonds_of(molecule, axis.a).aromatics < 2 ||
      bonds_of(molecule, axis.b).aromatics < 2)
    return std::nullopt;
  const Beside one = beside(molecule, axis.a, axis.b), other = beside(molecule, axis.b, axis.a);
  if (one.all.size() != 2 || other.all.size() != 2 || one.large.size() + other.large.size() < 3)
    return std::nullopt;
  return HinderedAxis{one.large.front(), axis.a, axis.b, other.large.front()};
}

PlanarUnits::PlanarUnits(const Molecule& molecule)
    : planar_atom_(molecule.atoms().size()),
      cumulated_atom_(molecule.atoms().size()),
      holds_shape_(molecule.atoms().size()),
      planar_bond_(molecule.bonds().size()) {
  // trigonal by its own bonds; cumulated and triple bonds are linear, S and P stay pyramidal
  for (int i = 0; i < int(molecule.atoms().size()); ++i) {
    const BondCount count = bonds_of(molecule, i);
    const int element = molecule.atoms()[std::size_t(i)].element;
    const bool second_row = element == B || element == C || element == N || element == O;
    const bool one_double = count.doubles == 1 && count.triples == 0 && second_row;
    planar_atom_[std::size_t(i)] =
        molecule.neighbours(i).size() <= 3 &&
        (one_double || count.aromatics > 0 || has_empty_orbital(molecule, i, count));
    cumulated_atom_[std::size_t(i)] =
        count.doubles == 2 && molecule.neighbours(i).size() == 2 && second_row;
    holds_shape_[std::size_t(i)] = count.datives == 0 || !is_metal(element);
  }

  // amide, guanidinium and their like: N beside such a carbon is flat, and their bond does not turn
  const std::vector<bool> trigonal = planar_atom_;
  for (std::size_t k = 0; k < molecule.bonds().size(); ++k) {
    const Bond& bond = molecule.bonds()[k];
    const bool both = trigonal[std::size_t(bond.a)] && trigonal[std::size_t(bond.b)];
    if (bond.order == BondOrder::double_bond || bond.order == BondOrder::aromatic) {
      planar_bond_[k] = both;
    } else if (bond.order == BondOrder::single || bond.order == BondOrder::unknown) {
      for (const auto& [c, n] : {std::pair(bond.a, bond.b), std::pair(bond.b, bond.a)}) {
        // an aromatic N turns about its bond to another ring or to a carbonyl
        if (molecule.atoms()[std::size_t(n)].element != N || molecule.neighbours(n).size() > 3 ||
            bonds_of(molecule, n).aromatics > 0 || bonds_of(molecule, n).doubles > 0 ||
            !trigonal[std::size_t(c)] || !draws_nitrogen_flat(molecule, c))
          continue;
        planar_bond_[k] = true;
        planar_atom_[std::size_t(n)] = true;
      }
    }
  }
}

double van_der_waals_radius(int element) {
  switch (element) {
    case H:
      return 0.110;
    case 2:
      return 0.140;
    case C:
      return 0.170;
    case N:
      return 0.155;
    case O:
      return 0.152;
    case F:
      return 0.147;
    case 14:
      return 0.210;
    case 15:
      return 0.180;
    case S:
      return 0.180;
    case 17:
      return 0.175;
    case 33:
      return 0.185;
    case 34:
      return 0.190;
    case 35:
      return 0.185;
    case 53:
      return 0.198;
    default:
      return 0.170;
  }
}

bool is_metal(int element) {
  const auto between = [element](int first, int last) {
    return first <= element && element <= last;
  };
  return between(3, 4) || between(11, 13) || between(19, 31) || between(37, 50) ||
         between(55, 84) || between(87, 116);
}

double covalent_radius(int element) {
  switch (element) {
    case H:
      return 0.031;
    case C:
      return 0.076;
    case N:
      return 0.071;
    case O:
      return 0.066;
    case S:
      return 0.105;
    case 3:  // Li
      return 0.128;
    case 11:  // Na
      return 0.166;
    case 12:  // Mg
      return 0.141;
    case 13:  // Al
      return 0.121;
    case 19:  // K
      return 0.203;
    case 20:  // Ca
      return 0.176;
    case 25:  // Mn
      return 0.139;
    case 26:  // Fe
    case 29:  // Cu
      return 0.132;
    case 27:  // Co
      return 0.126;
    case 28:  // Ni
      return 0.124;
    case 30:  // Zn
      return 0.122;
    case 42:  // Mo
      return 0.154;
    case 48:  // Cd
      return 0.144;
    case 80:  // Hg
      return 0.132;
    default:
      return element > 36 ? 0.160 : 0.140;
  }
}

Polarity polarity_of(const Molecule& molecule, int atom) {
  const auto polar = [&](int i) {
    const int element = molecule.atoms()[std::size_t(i)].element;
    return element == N || element == O || element == F || element == S;
  };
  if (polar(atom)) return Polarity::heavy;
  if (molecule.atoms()[std::size_t(atom)].element == H)
    for (const auto& [other, bond] : molecule.neighbours(atom))
      if (polar(other)) return Polarity::hydrogen;
  return Polarity::none;
}

}  // namespace ragdoll
