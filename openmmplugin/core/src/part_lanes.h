// PartLanes: candidates side by side, each with its turns and shapes; where their atoms are, and
// which of them come too near each other. Private to core.

#pragma once
#include <array>
#include <vector>

#include "part_tree.h"    // PartTree
#include "steric_rule.h"  // StericRule

namespace ragdoll {

/// What a part's atoms and what hangs on it take from its shape, in single precision.
struct LanePart {
  int parent = -1;
  int first = 0, last = 0;  ///< of LanePlan::atoms
  int place = 0;            ///< of this one among its parent's children
  int children = 0;
  int shapes = 1;
  std::array<float, 3> axis{}, origin{};
  std::vector<float> positions;  ///< (shape, atom, 3)
  std::vector<float> moves;      ///< (shape, child, 12): rotation by rows, translation
};

struct LanePair {
  int p, q;              ///< places in LanePlan::atoms
  float inverse_reach2;  ///< nm^-2
};

struct LanePlan {
  static constexpr int lanes = 16;

  std::vector<LanePart> parts;
  std::vector<int> atoms;       ///< those of parts side by side (natom)
  std::vector<int> part_of;     ///< (natom), by place
  std::vector<LanePair> pairs;  ///< those that more than one bond or shape decides

  /// @param turns_alone  leaves out pairs that torsion tables know
  LanePlan(const Molecule& molecule, const PartTree& tree, const StericRule& sterics);
};

/// One value for each lane.
using LaneFloats = std::array<float, LanePlan::lanes>;
using LaneInts = std::array<int, LanePlan::lanes>;

struct LaneState {
  explicit LaneState(const LanePlan& plan);

  std::vector<LaneInts> bins;      ///< degrees (npart)
  std::vector<LaneInts> shapes;    ///< (npart)
  std::vector<LaneFloats> places;  ///< nm (natom, 3), in the order of LanePlan::atoms
  LaneFloats sterics{};            ///< kJ/mol
  LaneFloats worst{};              ///< of one pair, kJ/mol
  LaneInts worst_pair{};           ///< of LanePlan::pairs; -1: none

  std::vector<LaneFloats> moves;  ///< scratch (npart, 12)
};

/// Places the atoms of all lanes and measures what comes too near.
void place_lanes(const LanePlan& plan, LaneState& state);

}  // namespace ragdoll
