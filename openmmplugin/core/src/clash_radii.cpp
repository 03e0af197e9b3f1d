#include "clash_radii.h"

namespace ragdoll {
namespace {

constexpr int H = 1, C = 6, N = 7, O = 8, S = 16;

const Atom& atom_at(const Molecule& molecule, int index) {
  return molecule.atoms()[std::size_t(index)];
}

bool has_order(const Molecule& molecule, int atom, BondOrder order) {
  for (const auto& [other, bond] : molecule.neighbours(atom))
    if (molecule.bonds()[std::size_t(bond)].order == order) return true;
  return false;
}

bool is_carbonyl(const Molecule& molecule, int atom) {
  for (const auto& [other, bond] : molecule.neighbours(atom))
    if (atom_at(molecule, other).element == O &&
        molecule.bonds()[std::size_t(bond)].order == BondOrder::double_bond)
      return true;
  return false;
}

}  // namespace

double heavy_clash_radius(int element) {
  switch (element) {
    case 5:
      return 0.192;
    case C:
      return 0.170;
    case N:
      return 0.155;
    case O:
      return 0.152;
    case 9:
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
      return 0;
  }
}

double all_atom_clash_radius(const Molecule& molecule, int atom) {
  switch (atom_at(molecule, atom).element) {
    case H: {
      if (is_polar_hydrogen(molecule, atom)) return 0.100;
      for (const auto& [other, bond] : molecule.neighbours(atom))
        if (has_order(molecule, other, BondOrder::aromatic)) return 0.100;
      return 0.117;
    }
    case C:
      return is_carbonyl(molecule, atom) ? 0.165 : 0.170;
    case O:
      return 0.140;
    default:
      return heavy_clash_radius(atom_at(molecule, atom).element);
  }
}

bool is_polar_hydrogen(const Molecule& molecule, int atom) {
  if (atom_at(molecule, atom).element != H) return false;
  for (const auto& [other, bond] : molecule.neighbours(atom)) {
    const int element = atom_at(molecule, other).element;
    if (element == N || element == O || element == S) return true;
  }
  return false;
}

bool is_acceptor(const Molecule& molecule, int atom) {
  const int element = atom_at(molecule, atom).element;
  if (element == O || element == S) return true;
  // a nitrogen with three neighbours or more has no pair to give, or gives it to a plane
  return element == N && molecule.neighbours(atom).size() <= 2;
}

}  // namespace ragdoll
