// PartTree: what a molecule consists of when its torsions turn: rigid parts, each hung on another
// by a bond, and the other shapes that a part can take. Private to core.

#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "ragdoll/molecule.h"         // Molecule
#include "ragdoll/ring_conformers.h"  // RingPool
#include "ragdoll/superposition.h"    // RigidMove
#include "ragdoll/torsion_term.h"     // TorsionTerm
#include "ragdoll/vec3.h"             // Vec3

namespace ragdoll {

/// A shape of a part, in the frame of the start: laid there so that the bond it hangs on, and the
/// atom that its torsion is measured by, are where they were.
struct PartShape {
  std::vector<Vec3> positions;   ///< nm, of Part::atoms
  std::vector<RigidMove> moves;  ///< where what hangs on it goes, of Part::children
  double energy = 0;             ///< kJ/mol
};

/// From so many atoms on a ring has many shapes, and scores hardly tell which of them it takes.
inline constexpr int large_ring = 8;

struct Part {
  int parent = -1;             ///< -1: this one holds the frame
  int inner = -1, outer = -1;  ///< atoms of the bond it hangs on, in the parent and in this one
  int before = -1,
      behind = -1;         ///< atoms that the torsion is measured by: before-inner-outer-behind
  std::vector<int> atoms;  ///< ascending
  std::vector<int> children;
  std::vector<PartShape>
      shapes;         ///< at least one: the start's comes first unless rings have others
  bool even = false;  ///< shapes are as likely as each other, whatever their energies
};

/// Bonds turn that are single, outside of rings, and lead to more than one atom on both sides;
/// those to metals do not.
class PartTree {
 public:
  /// @param terms  those about bonds that turn tell which atoms a torsion is measured by
  PartTree(const Molecule& molecule, std::span<const TorsionTerm> terms);

  /// Parents come before their children.
  const std::vector<Part>& parts() const { return parts_; }
  int part_of(int atom) const { return part_of_[std::size_t(atom)]; }
  int depth_of(int part) const { return depth_[std::size_t(part)]; }

  /// Parts whose bonds lie between two parts; of separate molecules: those up to both frames.
  std::vector<int> path(int one, int other) const;

  /// Gives parts the shapes of their rings, and turns nitrogens inside out.
  /// @param most_shapes  of each part
  void add_shapes(std::span<const RingPool> pools, int most_shapes);

 private:
  void find_parts();
  void choose_references(std::span<const TorsionTerm> terms);
  PartShape shape_of(int part, std::span<const RingPool> pools, std::span<const int> chosen,
                     std::span<const int> inverted) const;

  const Molecule& molecule_;
  std::vector<Part> parts_;
  std::vector<int> part_of_, depth_;
  std::vector<bool> turns_;  ///< (nbond)
};

/// Positions for turns of each part, in order of the parts. rad, nm
/// @param shapes  index of each part's shape
std::vector<Vec3> place_parts(const PartTree& tree, std::size_t atom_count,
                              std::span<const double> angles, std::span<const int> shapes,
                              std::span<const Vec3> start);

}  // namespace ragdoll
