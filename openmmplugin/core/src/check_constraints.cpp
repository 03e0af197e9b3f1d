#include <cmath>   // isfinite
#include <limits>  // min
#include <string>  // to_string

#include "noncovalent.h"    // check_constraints
#include "ragdoll/error.h"  // Error

namespace ragdoll {
namespace {

void check_atom(const Molecule& molecule, int atom) {
  const int count = int(molecule.atoms().size());
  if (atom < 0 || atom >= count)
    throw Error("a constraint names atom " + std::to_string(atom) + ", but there are " +
                std::to_string(count));
}

template <class Pair>
void check_pairs(const Molecule& molecule, const std::vector<Pair>& pairs, const std::string& noun,
                 double least) {
  for (const Pair& pair : pairs) {
    check_atom(molecule, pair.p);
    check_atom(molecule, pair.q);
    if (pair.p == pair.q)
      throw Error("a " + noun + " goes from " + molecule.name(pair.p) + " to itself");
    if (!std::isfinite(pair.length) || !(pair.length >= least))
      throw Error("the " + noun + " " + molecule.name(pair.p) + " - " + molecule.name(pair.q) +
                  " has a length that is not a positive number");
  }
}

}  // namespace

void check_constraints(const Molecule& molecule, const ConstraintOptions& constraints) {
  if (!(constraints.hydrogen_bond_room >= 0) || !(constraints.hydrogen_bond_room <= 1))
    throw Error("the room of hydrogen bonds must be from 0 to 1");
  if (!(constraints.metal_slack >= 0) || !(constraints.metal_slack <= 0.2))
    throw Error("the slack of metals must be from 0 to 0.2 nm");
  if (!(constraints.eclipsed_degree >= 0) || !(constraints.eclipsed_degree <= 60))
    throw Error("how near bonds come to the eclipsed position must be from 0 to 60 degrees");
  constexpr double positive = std::numeric_limits<double>::min();
  check_pairs(molecule, constraints.coordination, "bond of a metal", 0);
  check_pairs(molecule, constraints.bars, "bar", 0);
  check_pairs(molecule, constraints.tethers, "tether", positive);
  check_pairs(molecule, constraints.contacts, "contact", positive);
  for (const int atom : constraints.fixed) check_atom(molecule, atom);
}

}  // namespace ragdoll
