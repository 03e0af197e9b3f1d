#include "steric_rule.h"

#include <algorithm>  // sort, binary_search

#include "chemistry_rules.h"  // van_der_waals_radius, polarity_of

namespace ragdoll {
namespace {

constexpr double scale = 0.9;                ///< of the sum of van der Waals radii
constexpr double heavy_allowance = 0.01;     ///< nm, both polar
constexpr double hydrogen_allowance = 0.06;  ///< nm, a polar hydrogen and a polar heavy atom

}  // namespace

StericRule::StericRule(const Molecule& molecule) {
  const int natom = int(molecule.atoms().size());
  for (int i = 0; i < natom; ++i) {
    radius_.push_back(van_der_waals_radius(molecule.atoms()[std::size_t(i)].element));
    polarity_.push_back(int(polarity_of(molecule, i)));
  }
  near_.resize(std::size_t(natom));
  std::vector<int> seen(std::size_t(natom), -1);
  for (int i = 0; i < natom; ++i) {
    std::vector<int>& near = near_[std::size_t(i)];
    near.assign(1, i);
    seen[std::size_t(i)] = i;
    std::size_t first = 0;
    for (int bonds = 0; bonds < 3; ++bonds) {
      const std::size_t last = near.size();
      for (; first < last; ++first)
        for (const auto& [other, bond] : molecule.neighbours(near[first])) {
          if (seen[std::size_t(other)] == i) continue;
          seen[std::size_t(other)] = i;
          near.push_back(other);
        }
    }
    std::sort(near.begin(), near.end());
  }
}

double StericRule::reach(int p, int q) const {
  const std::vector<int>& near = near_[std::size_t(p)];
  if (std::binary_search(near.begin(), near.end(), q)) return 0;
  const double sum = scale * (radius_[std::size_t(p)] + radius_[std::size_t(q)]);
  const int kinds = polarity_[std::size_t(p)] + polarity_[std::size_t(q)];
  const bool both = polarity_[std::size_t(p)] > 0 && polarity_[std::size_t(q)] > 0;
  // 1 is a polar heavy atom, 2 a polar hydrogen
  if (both && kinds == 2) return sum - heavy_allowance;
  if (both && kinds == 3) return sum - hydrogen_allowance;
  return sum;
}

}  // namespace ragdoll
