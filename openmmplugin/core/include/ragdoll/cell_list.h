// CellList: joints sorted into cells, to find those near a point in constant time.

#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "ragdoll/box.h"   // Box
#include "ragdoll/vec3.h"  // Vec3

namespace ragdoll {

/// Cells at least `cutoff` wide, kept in a hash table, so that joints that flew far away cost no
/// memory. With a box the cells are of its fractional coordinates, and wrap around.
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
  Cell cell_of(const Vec3& position) const;
  std::size_t bucket_of(const Cell& cell) const;

  std::span<const Vec3> positions_;
  double cutoff_;
  const Box* box_;
  std::int64_t count_[3] = {0, 0, 0};  ///< cells along each box vector; 0: no box
  std::size_t mask_ = 0;
  std::vector<Cell> cells_;         ///< of each joint (njoint)
  std::vector<int> bucket_begin_;   ///< (nbucket + 1)
  std::vector<int> bucket_joints_;  ///< joints by bucket, ascending in each (njoint)
};

}  // namespace ragdoll
