// Rigidity: what in a network of bodies and bars can move: degrees of freedom, rigid clusters,
// hinges, and where there are more bars than needed.

#pragma once
#include <vector>

namespace ragdoll {

/// Bars between two bodies; each takes away one of their six relative motions.
struct BodyBond {
  int a = 0, b = 0;  ///< bodies
  int bars = 0;      ///< 1 to 6; a hinge has five
};

struct BodyBarNetwork {
  int bodies = 0;
  std::vector<BodyBond> bonds;

  /// The spin of an atom about its only bond is no motion: a hinge with an end that meets no other
  /// bond has six bars.
  bool lock_leaves = true;
};

inline constexpr int hinge_bars = 5, rigid_bars = 6;

struct Rigidity {
  int degrees_of_freedom = 0;  ///< those of each separate body's place and turn included
  int floppy_modes = 0;        ///< without these six of each separate body
  int separate_bodies = 0;     ///< that no bond joins
  int redundant_bars = 0;

  /// Each body is in one cluster. Clusters are numbered by size, the largest first, and by their
  /// lowest bodies on ties.
  std::vector<int> cluster_of_body;  ///< (nbody)
  std::vector<int> cluster_sizes;    ///< bodies (ncluster)

  /// Sets of bodies with more bars between them than it takes, numbered alike; -1 elsewhere.
  std::vector<int> region_of_body;  ///< (nbody)
  std::vector<int> region_sizes;    ///< bodies (nregion)

  std::vector<int> hinges;  ///< bonds of five bars between two clusters
};

/// By the pebble game; near linear in the number of bonds.
/// @throw Error  no bodies, a bond to a body that there is not or to itself, bars not 1 to 6
Rigidity analyse_rigidity(const BodyBarNetwork& network);

}  // namespace ragdoll
