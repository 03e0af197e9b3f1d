#include "ragdoll/molecule.h"

#include <cmath>    // isfinite
#include <utility>  // move, pair

#include "ragdoll/error.h"  // Error

namespace ragdoll {

Molecule::Molecule(std::vector<Atom> atoms, std::vector<Bond> bonds, std::vector<Vec3> positions)
    : atoms_(std::move(atoms)), bonds_(std::move(bonds)), positions_(std::move(positions)) {
  if (atoms_.empty()) throw Error("the molecule has no atoms");
  if (positions_.size() != atoms_.size())
    throw Error("the molecule has " + std::to_string(atoms_.size()) + " atoms but " +
                std::to_string(positions_.size()) + " positions");
  for (std::size_t i = 0; i < atoms_.size(); ++i)
    if (!positions_[i].allFinite())
      throw Error("a coordinate of " + name(int(i)) + " is not a finite number");

  neighbours_.resize(atoms_.size());
  const int n = int(atoms_.size());
  for (std::size_t k = 0; k < bonds_.size(); ++k) {
    const Bond& bond = bonds_[k];
    if (bond.a < 0 || bond.b < 0 || bond.a >= n || bond.b >= n)
      throw Error("bond " + std::to_string(k) + " names an atom that the molecule does not have");
    if (bond.a == bond.b) throw Error("a bond joins " + name(bond.a) + " to itself");
    for (const Neighbour& other : neighbours_[std::size_t(bond.a)])
      if (other.atom == bond.b)
        throw Error("two bonds join " + name(bond.a) + " and " + name(bond.b));
    neighbours_[std::size_t(bond.a)].push_back({bond.b, int(k)});
    neighbours_[std::size_t(bond.b)].push_back({bond.a, int(k)});
  }
}

std::string Molecule::name(int atom) const {
  const std::string& label = atoms_[std::size_t(atom)].label;
  return label.empty() ? "atom " + std::to_string(atom) : label;
}

}  // namespace ragdoll
