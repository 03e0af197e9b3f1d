// Generate: structures of a class, and forces that act on them, at random but repeatable.

#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "ragdoll/molecule.h"   // Molecule
#include "ragdoll/structure.h"  // Structure, ForceSet

namespace ragdoll {

/// What is asked for. 0 and "" leave the choice to the seed.
struct StructureRequest {
  std::string class_name = "tree";  ///< see structure_classes()
  std::string type = {};            ///< of a 2-cycle: "path", "shared-joint", "theta"
  std::string construction = {};    ///< of a 1-cycle: "a" or "b"; of a 2-cycle: "a" to "d"
  int cycles = 0;                   ///< n-cycle: bars beside the tree's; ring-chain: rings
  int joints = 20;                  ///< met exactly
  int depth = 0, children = 0;      ///< of a tree at most; depth 0: as deep as it gets
  int dimensions = 0;               ///< of a grid: 2 or 3
  int degree = 0;                   ///< of a regular graph
  std::uint64_t seed = 0;
  std::uint64_t index = 0;  ///< which structure of a set: each has its own random numbers
};

/// The thesis' classes
///   tree     each joint gets up to `children` joints of its own, down to `depth`
///   1-cycle  a: a tree and a bar between an unconnected pair
///            b: a closed chain with trees hung on it
///   2-cycle  a: a tree and two bars               b: two cycles that share a joint
///            c: two cycles joined by a chain      d: a cycle and a path between two of its joints;
///            b, c and d with trees hung on them; the type that comes out is stated
///   n-cycle  a tree and `cycles` bars, 3 or more
/// and others
///   grid        a square or cubic lattice, its last row cut where the joints end
///   cloth       a sheet of triangles
///   thread      a chain whose bending is held by bars from each joint to the next but one
///   ring-chain  rings of 3 to 8 joints, each joined to the next by a bar
///   regular     a connected graph in which every joint has `degree` bars
///   protein     backbone, side chains with their rings, and disulfides between cysteines
/// Joints of lattices, threads and rings stand about 1 apart, moved a little at random; a protein's
/// bars are 1 long but where they close a ring; all others are at random in a box in which two
/// joints are 1 apart on average. Joints are named j0, j1, ...; masses are 1; bars have their
/// present lengths. Linear time and memory, without recursion.
/// @throw Error if no such structure exists; it says why
Structure generate_structure(const StructureRequest& request);

/// Names of the classes, in the order above.
std::vector<std::string> structure_classes();

/// A molecule as a structure: a joint for each atom, a bar for each bond, lengths in nm. Labels are
/// the names where they are all different, spaces replaced. Class and type are those of its graph.
/// @throw Error if two bonded atoms are at one place
Structure structure_of(const Molecule& molecule);

struct ForceRequest {
  int count = 50;
  double lo = 0.1, hi = 2;  ///< mean bar lengths
  std::uint64_t seed = 0;
  std::uint64_t index = 0;  ///< which set of forces
};

/// |F|/m dt^2 uniform between lo and hi mean bar lengths, dt = 1, the direction uniform on the
/// sphere, the joint uniform among those that can move.
/// @throw Error if no joint can move, there is no bar, or lo and hi are no range
ForceSet generate_forces(const Structure& structure, const ForceRequest& request);

}  // namespace ragdoll
