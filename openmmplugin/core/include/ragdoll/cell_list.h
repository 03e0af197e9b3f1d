// CellList: joints sorted into cells, to find those near a point in constant time.

#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "ragdoll/box.h"   // Box
#include "ragdoll/vec3.h"  // Vec3

namespace ragdoll {

/// Cells at least `cutoff` wide; only those that hold joints are kept, so that joints that flew far
/// away cost no memory. With a box the cells are of its fractional coordinates, and wrap around.
class CellList {
 public:
  CellList(std::span<const Vec3> positions, double cutoff, const Box* box);

  /// Appends every joint q > p whose (minimum image) distance from joint p is below the cutoff,
  /// in no particular order.
  void append_partners(int p, std::vector<int>& partners) const;

 private:
  struct Cell {
    std::int64_t x, y, z;
    bool operator==(const Cell&) const = default;
  };
  /// A joint beside its neighbours in memory.
  struct Resident {
    Vec3 position;
    int joint;
  };
  Cell cell_at(const Vec3& position) const;
  std::size_t slot_of(const Cell& cell) const;
  void find_neighbours();

  double cutoff_;
  const Box* box_;
  std::int64_t count_[3] = {0, 0, 0};  ///< cells along each box vector; 0: no box
  std::size_t mask_ = 0;
  std::vector<int> slots_;           ///< hash table: index of a cell, or -1
  std::vector<Cell> cells_;          ///< that hold joints (ncell)
  std::vector<int> of_joint_;        ///< cell (njoint)
  std::vector<int> place_;           ///< among the residents (njoint)
  std::vector<int> begin_;           ///< first resident (ncell + 1)
  std::vector<Resident> residents_;  ///< by cell, ascending in each (njoint)
  std::vector<int> around_begin_;    ///< (ncell + 1)
  std::vector<int> around_;          ///< cells around each cell, itself included
};

}  // namespace ragdoll
