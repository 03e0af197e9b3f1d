// Contact kernels: the inner loops of finding contacts, for whatever vectors the processor has.
// Private to core.

#pragma once
#include <span>
#include <vector>

#include "ragdoll/cell_list.h"  // CellPair
#include "ragdoll/vec3.h"       // Vec3

namespace ragdoll::contact_kernels {

/// Readers of residents may read so many beyond the last.
constexpr std::size_t padding = 64;

/// Joints in order of their cells; each place is relative to the centre of its cell.
struct Residents {
  const int* joints;
  const float *x, *y, *z;
};

/// Residents first to last - 1, of a cell whose centre lies at `shift` from the home cell's.
struct Neighbours {
  int first, last;
  float shift[3];
};

/// Appends the pairs of the home cell's residents (first to last - 1), among themselves and with
/// those of its neighbours, that are not surely as far apart as `limit`. Places that are no numbers
/// are near everything.
/// @param margin  what distances may be wrong by, nm
void find_near(const Residents& residents, int first, int last,
               std::span<const Neighbours> neighbours, float limit, float margin,
               std::vector<CellPair>& pairs);

/// The two largest of some distances.
struct Largest {
  float first = 0, second = 0;
  float sum() const { return first + second; }
};

/// How far each joint is from its reference at most: the distance, or the next floats above it.
/// @param moved  (njoint), nm
Largest measure_moves(std::span<const Vec3> positions, std::span<const Vec3> reference,
                      std::span<float> moved);

/// The indices of the values that are at most the limit.
/// @param selected  room for as many as there are values
/// @return how many there are
std::size_t select_below(std::span<const float> values, float limit, std::span<int> selected);

}  // namespace ragdoll::contact_kernels
