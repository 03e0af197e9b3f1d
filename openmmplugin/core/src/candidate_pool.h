// CandidatePool: arrangements of a molecule's parts without clashes, at random. Private to core.

#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "part_lanes.h"      // LanePlan, LaneState
#include "part_tree.h"       // PartTree
#include "ragdoll/random.h"  // Random
#include "torsion_table.h"   // TorsionTable

namespace ragdoll {

class CandidatePool {
 public:
  /// @param places  atoms that candidates are compared by
  CandidatePool(const Molecule& molecule, const PartTree& tree, const StericRule& sterics,
                std::vector<TorsionTable> tables, std::uint64_t seed, std::vector<int> places);

  /// Whether anything turns or has more than one shape.
  bool has_freedom() const { return !movable_.empty(); }

  /// Takes more attempts until there are so many candidates, or work has grown too much.
  /// @param keep_going  may be empty
  /// @return false if keep_going said no
  bool fill(std::size_t wanted, const std::function<bool()>& keep_going);

  /// Whether there is nothing but one part, of many shapes.
  bool only_shapes() const;

  /// Which shape the first part that is even has in a candidate; -1: there is no such part.
  int even_shape(std::size_t k) const;

  /// Each of these shapes once.
  void fill_with_shapes();

  std::size_t pair_count() const { return plan_.pairs.size(); }
  std::size_t size() const { return energies_.size(); }
  long rejected() const { return rejected_; }
  bool exhausted() const { return work_ > most_work_; }
  double energy(std::size_t k) const { return energies_[k]; }  ///< kJ/mol
  std::span<const float> places(std::size_t k) const {         ///< nm (nplace, 3)
    return {places_.data() + k * 3 * compared_.size(), 3 * compared_.size()};
  }

  /// nm (natom)
  std::vector<Vec3> positions(std::size_t k) const;

  void clear();  ///< of candidates; the next ones are others

 private:
  struct Lane;
  void draw(Lane& lane, std::size_t l);
  void draw_one(Lane& lane, std::size_t l, int part);
  void harvest(std::size_t l);
  bool repair(Lane& lane, std::size_t l);
  void judge(bool accepted);

  const Molecule& molecule_;
  const PartTree& tree_;
  std::vector<TorsionTable> tables_;
  LanePlan plan_;
  LaneState state_;
  std::uint64_t seed_, attempts_ = 0;
  std::vector<int> compared_;  ///< places in the plan, of atoms that are compared
  std::vector<int> movable_;   ///< parts with a turn or shapes
  std::vector<std::vector<float>> shape_chance_;           ///< cumulative (npart)
  float worst_allowed_ = float(StericRule::clash_energy);  ///< of a pair, kJ/mol
  int ended_ = 0, given_up_ = 0;                           ///< attempts since that was last judged
  double work_ = 0, most_work_ = 0;  ///< pairs looked at, in one call of fill()
  double unasked_ = 0;               ///< since keep_going was asked
  long rejected_ = 0;

  std::vector<float> energies_, places_;
  std::vector<std::uint16_t> bins_, shapes_;  ///< (ncandidate, npart)
};

}  // namespace ragdoll
