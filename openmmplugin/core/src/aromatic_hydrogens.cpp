#include "aromatic_hydrogens.h"

#include <algorithm>  // find
#include <bit>        // popcount
#include <utility>    // move

namespace ragdoll {
namespace {

constexpr int C = 6, N = 7;
constexpr std::size_t largest_system = 60, most_open = 8;

/// An aromatic system: atoms joined by aromatic bonds.
class System {
 public:
  System(const Molecule& molecule, std::vector<int> atoms)
      : molecule_(molecule), atoms_(std::move(atoms)) {
    for (const int atom : atoms_)
      if (state_of(atom) == open) open_.push_back(atom);
  }

  std::vector<std::vector<int>> sets() {
    std::vector<std::vector<int>> found;
    if (atoms_.size() > largest_system || open_.empty() || open_.size() > most_open) return found;
    int fewest = int(open_.size()) + 1, most_carbonyls = -1;
    for (unsigned mask = 0; mask < 1u << open_.size(); ++mask) {
      const int count = std::popcount(mask);
      if (count > fewest || !has_double_bonds(mask)) continue;
      std::vector<int> set;
      int carbonyls = 0;
      for (std::size_t k = 0; k < open_.size(); ++k) {
        if (!(mask >> k & 1)) continue;
        set.push_back(open_[k]);
        carbonyls += beside_carbonyls(open_[k]);
      }
      if (count < fewest || carbonyls > most_carbonyls) found.clear();
      if (count == fewest && carbonyls < most_carbonyls) continue;
      fewest = count;
      most_carbonyls = carbonyls;
      found.push_back(set);
    }
    if (fewest == 0) found.clear();
    return found;
  }

 private:
  enum State : char { none, must, open };  ///< of a double bond in the system

  bool is_aromatic(int bond) const {
    return molecule_.bonds()[std::size_t(bond)].order == BondOrder::aromatic;
  }

  State state_of(int atom) const {
    const Atom& a = molecule_.atoms()[std::size_t(atom)];
    const auto& around = molecule_.neighbours(atom);
    if (a.element == C) {
      for (const auto& [other, bond] : around)
        if (molecule_.bonds()[std::size_t(bond)].order == BondOrder::double_bond) return none;
      return must;
    }
    if (a.element == N && around.size() == 2) return a.formal_charge > 0 ? must : open;
    if (a.element == N && around.size() == 3) return a.formal_charge > 0 ? must : none;
    return none;
  }

  /// Whether all but those without can have one double bond each. @param mask  open ones that bear
  /// a hydrogen in its place
  bool has_double_bonds(unsigned mask) {
    free_.clear();
    for (const int atom : atoms_)
      if (state_of(atom) == must) free_.push_back(atom);
    for (std::size_t k = 0; k < open_.size(); ++k)
      if (!(mask >> k & 1)) free_.push_back(open_[k]);
    return pair_up();
  }

  bool pair_up() {
    if (free_.empty()) return true;
    const int atom = free_.back();
    free_.pop_back();
    for (const auto& [other, bond] : molecule_.neighbours(atom)) {
      if (!is_aromatic(bond)) continue;
      const auto at = std::find(free_.begin(), free_.end(), other);
      if (at == free_.end()) continue;
      const auto place = at - free_.begin();
      free_.erase(at);
      if (pair_up()) return true;
      free_.insert(free_.begin() + place, other);
    }
    free_.push_back(atom);
    return false;
  }

  int beside_carbonyls(int atom) const {
    int count = 0;
    for (const auto& [other, bond] : molecule_.neighbours(atom))
      count += is_aromatic(bond) && molecule_.atoms()[std::size_t(other)].element == C &&
               state_of(other) == none;
    return count;
  }

  const Molecule& molecule_;
  std::vector<int> atoms_, open_, free_;
};

}  // namespace

std::vector<std::vector<std::vector<int>>> aromatic_hydrogen_sets(const Molecule& molecule) {
  std::vector<std::vector<std::vector<int>>> all;
  std::vector<bool> seen(molecule.atoms().size());
  for (int start = 0; start < int(molecule.atoms().size()); ++start) {
    if (seen[std::size_t(start)]) continue;
    std::vector<int> atoms = {start};
    seen[std::size_t(start)] = true;
    for (std::size_t head = 0; head < atoms.size(); ++head)
      for (const auto& [other, bond] : molecule.neighbours(atoms[head]))
        if (molecule.bonds()[std::size_t(bond)].order == BondOrder::aromatic &&
            !seen[std::size_t(other)]) {
          seen[std::size_t(other)] = true;
          atoms.push_back(other);
        }
    if (atoms.size() < 3) continue;
    auto sets = System(molecule, std::move(atoms)).sets();
    if (!sets.empty()) all.push_back(std::move(sets));
  }
  return all;
}

}  // namespace ragdoll
