#include "surroundings.h"

namespace ragdoll {
namespace {

std::uint64_t mixed(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  return z ^ (z >> 31);
}

}  // namespace

std::vector<std::uint64_t> surroundings(const Molecule& molecule) {
  const std::size_t n = molecule.atoms().size();
  std::vector<std::uint64_t> colour(n), next(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Atom& atom = molecule.atoms()[i];
    colour[i] = mixed(std::uint64_t(atom.element) * 1009 + std::uint64_t(atom.formal_charge + 64) +
                      (molecule.neighbours(int(i)).size() << 20));
  }
  for (int round = 0; round < 12; ++round) {
    for (std::size_t i = 0; i < n; ++i) {
      std::uint64_t sum = 0;
      for (const auto& [other, bond] : molecule.neighbours(int(i)))
        sum += mixed(colour[std::size_t(other)] * 8 +
                     std::uint64_t(molecule.bonds()[std::size_t(bond)].order));
      next[i] = mixed(colour[i] * 3 + sum);
    }
    colour.swap(next);
  }
  return colour;
}

}  // namespace ragdoll
