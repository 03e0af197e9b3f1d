// Molecule file: a molecule as benchmarks/run hands it over. Text: "natom nbond", natom lines
// "element charge mass x y z" (nm), nbond lines "a b order".

#pragma once
#include <fstream>  // ifstream, ofstream
#include <string>
#include <utility>  // move
#include <vector>

#include "ragdoll/error.h"     // Error
#include "ragdoll/molecule.h"  // Molecule

namespace benchmark {

inline ragdoll::Molecule read_molecule(const std::string& path) {
  std::ifstream file(path);
  std::size_t natom = 0, nbond = 0;
  file >> natom >> nbond;
  std::vector<ragdoll::Atom> atoms(natom);
  std::vector<ragdoll::Vec3> positions(natom);
  for (std::size_t k = 0; k < natom; ++k)
    file >> atoms[k].element >> atoms[k].formal_charge >> atoms[k].mass >> positions[k][0] >>
        positions[k][1] >> positions[k][2];
  std::vector<ragdoll::Bond> bonds(nbond);
  for (ragdoll::Bond& bond : bonds) {
    int order = 0;
    file >> bond.a >> bond.b >> order;
    bond.order = ragdoll::BondOrder(order);
  }
  if (!file) throw ragdoll::Error(path + " holds no molecule");
  return {std::move(atoms), std::move(bonds), std::move(positions)};
}

inline void write_molecule(const std::string& path, const ragdoll::Molecule& molecule) {
  std::ofstream file(path);
  file.precision(17);
  file << molecule.atoms().size() << ' ' << molecule.bonds().size() << '\n';
  for (std::size_t k = 0; k < molecule.atoms().size(); ++k) {
    const ragdoll::Atom& atom = molecule.atoms()[k];
    file << atom.element << ' ' << atom.formal_charge << ' ' << atom.mass << ' '
         << molecule.positions()[k].transpose() << '\n';
  }
  for (const ragdoll::Bond& bond : molecule.bonds())
    file << bond.a << ' ' << bond.b << ' ' << int(bond.order) << '\n';
  if (!file) throw ragdoll::Error(path + " cannot be written");
}

}  // namespace benchmark
