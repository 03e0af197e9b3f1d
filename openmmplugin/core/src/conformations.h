// Conformations: a molecule's own positions and further ones that constraints have to allow.
// Private to build_framework.

#pragma once
#include <algorithm>  // max, min
#include <string>     // to_string
#include <vector>

#include "ragdoll/error.h"     // Error
#include "ragdoll/molecule.h"  // Molecule
#include "ragdoll/vec3.h"      // Vec3

namespace ragdoll {

class Conformations {
 public:
  /// @throw Error  further positions of another number, or that are no numbers
  Conformations(const Molecule& molecule, const std::vector<std::vector<Vec3>>& further) {
    all_.push_back(&molecule.positions());
    for (const std::vector<Vec3>& positions : further) {
      if (positions.size() != molecule.atoms().size())
        throw Error("a conformation has " + std::to_string(positions.size()) +
                    " positions instead of " + std::to_string(molecule.atoms().size()));
      for (const Vec3& position : positions)
        if (!position.allFinite())
          throw Error("a coordinate of a conformation is not a finite number");
      all_.push_back(&positions);
    }
  }

  std::size_t count() const { return all_.size(); }
  const std::vector<Vec3>& at(std::size_t k) const { return *all_[k]; }

  /// Distances over all of them. nm
  double shortest(int p, int q) const {
    double length = distance(0, p, q);
    for (std::size_t k = 1; k < all_.size(); ++k) length = std::min(length, distance(k, p, q));
    return length;
  }
  double longest(int p, int q) const {
    double length = distance(0, p, q);
    for (std::size_t k = 1; k < all_.size(); ++k) length = std::max(length, distance(k, p, q));
    return length;
  }

 private:
  double distance(std::size_t k, int p, int q) const {
    return ((*all_[k])[std::size_t(q)] - (*all_[k])[std::size_t(p)]).norm();
  }

  std::vector<const std::vector<Vec3>*> all_;
};

}  // namespace ragdoll
