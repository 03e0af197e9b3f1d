// RamachandranDensity: how often backbone torsions are found, on a grid, and where a residue
// stands.

#pragma once
#include <vector>

namespace ragdoll {

enum class RamachandranRegion { core, allowed, outlier };

/// A square grid over one turn of phi and psi; its nearest point tells.
class RamachandranDensity {
 public:
  /// @param density  row by row: one row for each psi, one column for each phi, both from -180
  ///                 degrees on in equal steps (side * side)
  /// @param core     least density of the core
  /// @param allowed  least density that is no outlier
  /// @throw Error    if the grid is no square, or the levels are in the wrong order
  RamachandranDensity(std::vector<double> density, double core, double allowed);

  int side() const { return side_; }  ///< cells of a turn
  double density(double phi_degree, double psi_degree) const;
  RamachandranRegion region(double phi_degree, double psi_degree) const;

 private:
  std::vector<double> density_;
  int side_ = 0;
  double core_, allowed_;
};

}  // namespace ragdoll
