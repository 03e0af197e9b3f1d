// CellList: joints sorted into cells, to find the pairs that are near each other in linear time.

#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "ragdoll/box.h"   // Box
#include "ragdoll/vec3.h"  // Vec3

namespace ragdoll {

/// A pair that may be near, p < q.
struct CellPair {
  int p = 0, q = 0;
  float distance = 0;  ///< the (minimum image) distance is at least this, nm
};

/// Cells slightly wider than `cutoff`; only those that hold joints are kept, so that joints that
/// flew far away cost no memory. With a box the cells are of its fractional coordinates, and wrap
/// around.
class CellList {
 public:
  /// @param positions  finite; they must outlive the list
  CellList(std::span<const Vec3> positions, double cutoff, const Box* box);

  /// Cells that hold joints.
  std::size_t cell_count() const { return cells_.size(); }

  /// Appends the pairs of a cell: over all cells, every pair whose (minimum image) distance is
  /// below the cutoff, and a few more; each once, in no particular order. Single precision decides,
  /// where it can tell.
  void find_candidates(std::size_t cell, std::vector<CellPair>& pairs) const;

 private:
  struct Cell {
    std::int64_t x, y, z;
    bool operator==(const Cell&) const = default;
  };
  Cell cell_at(const Vec3& position, Vec3& from_centre) const;
  bool small_box() const;
  std::size_t slot_of(const Cell& cell) const;
  int index_of(const Cell& cell) const { return slots_[slot_of(cell)]; }
  void find_in_small_box(std::size_t cell, std::vector<CellPair>& pairs) const;

  std::span<const Vec3> positions_;
  double cutoff_, width_;
  const Box* box_;
  std::int64_t count_[3] = {0, 0, 0};  ///< cells along each box vector; 0: no box
  Vec3 edges_[3];                      ///< of a cell
  std::size_t mask_ = 0;
  std::vector<int> slots_;   ///< hash table: index of a cell, or -1
  std::vector<Cell> cells_;  ///< that hold joints (ncell)
  std::vector<int> begin_;   ///< first resident (ncell + 1)
  std::vector<int> joints_;  ///< the residents: by cell, ascending in each (njoint)
  std::vector<float> x_, y_,
      z_;  ///< of the residents, from the centre of their cell, nm; not a
           ///< number: unknown. Padded, so that vectors may read past the end
};

}  // namespace ragdoll
