// StericRule: how near two atoms of a small molecule may come. Private to core.

#pragma once
#include <vector>

#include "ragdoll/molecule.h"  // Molecule

namespace ragdoll {

/// A pair is penalised by strength (1 - d^2 / reach^2)^2 below its reach; it clashes below a share
/// of that.
class StericRule {
 public:
  explicit StericRule(const Molecule& molecule);

  /// nm; 0 for pairs that are not looked at: those within three bonds of each other
  double reach(int p, int q) const;

  static constexpr double strength = 60;       ///< kJ/mol
  static constexpr double clash_share = 0.87;  ///< of the reach
  /// kJ/mol, that of a pair which clashes
  static constexpr double clash_energy =
      strength * (1 - clash_share * clash_share) * (1 - clash_share * clash_share);

  static double energy(double distance2, double reach) {
    const double lack = 1 - distance2 / (reach * reach);
    return lack > 0 ? strength * lack * lack : 0;
  }

 private:
  std::vector<double> radius_;
  std::vector<int> polarity_;
  std::vector<std::vector<int>> near_;  ///< atoms within three bonds, ascending (natom)
};

}  // namespace ragdoll
