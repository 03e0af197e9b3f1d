// NewtonPlan: everything about a framework that the solver `newton` works out once: the order of
// elimination, the pattern of the factor, and where each constraint enters. Private to `newton`.

#pragma once
#include <array>
#include <cstdint>
#include <limits>  // quiet_NaN
#include <span>
#include <utility>  // pair
#include <vector>

#include "ragdoll/framework.h"  // Framework
#include "ragdoll/vec3.h"       // Vec3

namespace ragdoll {
class NewtonRange;

/// Joints are known by slots: those that move first, in the order of their elimination, then the
/// fixed ones. So neighbours in the molecule are neighbours in memory, and what a column of the
/// factor needs was made shortly before.
struct NewtonPlan {
  /// Products of blocks that a factor of so many joints may take.
  static double most_products(int joints);

  /// @param whole  tethers and contacts far across are in the pattern, too, whatever that costs
  NewtonPlan(const Framework& framework, double most_products, bool whole = false);

  /// A factor would take too many products: it is not planned, nor what follows below the volumes.
  /// Joints are in their natural order.
  bool is_bulky = false;

  /// Largest violations of pairs and volumes, relative and in nm, as a ResolveReport has them.
  /// @param positions  by joint
  std::pair<double, double> measure(std::span<const Vec3> positions) const;

  /// |q - p| of a bar (side 0), tether (1) or contact (-1).
  struct Pair {
    int p = 0, q = 0;  ///< slots
    int side = 0;
    double length = 0;
  };
  struct Corners {
    std::array<int, 4> slot{};
    double lower = 0, upper = 0, scale = 0;
    /// The value that the bars between all four joints leave it within its bounds; or NaN, where
    /// there are fewer bars, or where they leave none or either of two.
    double aim = std::numeric_limits<double>::quiet_NaN();
    int mirror = -1;  ///< its group, where the aim or its mirror image is as good; the same one for
                      ///< all of a group
  };

  int joints = 0, moving = 0;
  std::vector<int> slot, joint;  ///< of each joint; of each slot (njoint)
  std::vector<double> masses;    ///< by slot, over the mean of those that move (njoint)
  std::vector<Pair> pairs;       ///< sorted by slots, then spread so that neighbours are apart
  std::vector<Pair> far;         ///< tethers and contacts that the pattern does not know of, sorted
  std::vector<Corners> volumes;
  int mirrors = 0;  ///< groups

  // The factor below its diagonal, by columns: blocks of column k, their rows in ascending order.
  std::vector<std::int64_t> column;  ///< (moving + 1)
  std::vector<int> row;              ///< (nblock)

  /// What makes a block before the elimination: one pair (or -1) ...
  std::vector<int> block_pair;  ///< (nblock)
  /// ... and where more constraints meet on it, these, by column.
  struct Addition {
    int volume = -1;                ///< less than 0: a pair
    int block = 0;                  ///< of its column
    std::uint8_t row = 0, col = 0;  ///< the volume's corners
    int pair() const { return -1 - volume; }
  };
  std::vector<int> addition_begin;  ///< (moving + 1)
  std::vector<Addition> additions;

  /// Ends of pairs at each slot: 2 * pair + (1 for q); corners of volumes: 4 * volume + corner.
  std::vector<int> end_begin, corner_begin;  ///< (moving + 1)
  std::vector<int> ends, corners;

  /// The elimination: row k of the factor is made of these blocks, columns ascending. A source
  /// block and those below it in its column are subtracted, times the source, from column k: the
  /// first from its diagonal, the others from the blocks that `target` names.
  struct Source {
    int column = 0, panel = 0;
    int place = 0, below = 0;  ///< of the block in the panel; how many are below it
  };
  std::vector<int> source_begin;  ///< (moving + 1)
  std::vector<Source> sources;
  std::vector<int> target;  ///< in the order of their use, within column k
  int blocks_of(int k) const { return int(column[std::size_t(k) + 1] - column[std::size_t(k)]); }

  /// Where each column is while others are made of it: first its diagonal block, then the others.
  /// Columns take the places of those that are done with.
  std::vector<int> panel;  ///< (moving), in blocks
  int panel_blocks = 0;

 private:
  void place_joints(const Framework& framework, double most, const NewtonRange& range);
  void place_constraints(const Framework& framework, const NewtonRange& range);
  void aim_volumes(const Framework& framework);
  void make_pattern();
  void fill_pattern();
  void place_panels();
  void enter_constraints();
};

}  // namespace ragdoll
