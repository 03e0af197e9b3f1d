// BackboneGuide: peptide planes turned so that phi and psi of residues become plausible, while CA
// atoms stay where they are.

#pragma once
#include <span>
#include <vector>

#include "ragdoll/ramachandran_density.h"  // RamachandranDensity
#include "ragdoll/vec3.h"                  // Vec3

namespace ragdoll {

/// A residue with neighbours on both sides.
struct GuidedResidue {
  int before = 0;  ///< C of the residue before
  int n = 0, ca = 0, c = 0;
  int after = 0;  ///< N of the residue after
  /// Planes of the peptide bonds on both sides, indices of BackboneGuide's; -1: one that does not
  /// turn, such as proline's.
  int plane_before = -1, plane_after = -1;
  bool to_core = false;  ///< is led back wherever it leaves the core; else only where it is an
                         ///< outlier
};

/// What turns about the line between two CA atoms: C, O, N and H of a peptide bond.
struct PeptidePlane {
  int from = 0, to = 0;  ///< CA before and after
  std::vector<int> atoms;
};

class BackboneGuide {
 public:
  /// @param most  the most that a plane turns at a time, rad
  BackboneGuide(const RamachandranDensity& map, std::vector<GuidedResidue> residues,
                std::vector<PeptidePlane> planes, double most);

  /// Turns planes towards the nearest place on the map where their residues are to be.
  /// @param share  of the most that planes turn
  /// @return       how far planes were to turn in all, rad
  double move(std::span<Vec3> positions, double share = 1) const;

 private:
  struct Way {
    float phi = 0, psi = 0;  ///< degrees to the nearest place of the region
  };
  Way way(const GuidedResidue& residue, std::span<const Vec3> positions) const;

  std::vector<Way> to_core_, to_allowed_;  ///< from each cell of the map
  int side_;
  std::vector<GuidedResidue> residues_;
  std::vector<PeptidePlane> planes_;
  double most_;
};

}  // namespace ragdoll
