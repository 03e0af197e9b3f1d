// Newton bars kernel: the arithmetic of NewtonBars on conformers side by side, one in each lane of
// a vector, or on one alone: the same operations in the same order, so that the bits are the same.
// Private to the resolvers.

#pragma once
#include <cstddef>
#include <cstdint>

namespace ragdoll {

/// What the kernel works on. Arrays of lanes hold a vector for each entry, aligned.
template <class T>
struct NewtonBarsTask {
  struct BarRow {
    int p, q;
    T length, per_length, per_slack;
    T near_weight, far_weight, weight;  ///< weight: of both ends
  };
  struct Entry {
    int row, column;
    T coupling;
  };

  std::size_t bar_count, entry_count;
  const BarRow* bars;
  const Entry* entries;
  const int* begin;
  const int* targets;
  std::size_t taken_from_count;
  const int* taken_from;              ///< entries that columns before their own change
  const std::uint8_t* is_taken_from;  ///< 1: it is one of these (nentry)
  T least_pivot;

  T* x;           ///< (njoint, 3, lanes)
  T* d;           ///< from p to q (nbar, 3, lanes)
  T* value;       ///< diagonal, then 1 over pivots; entries (nbar + nentry, lanes)
  T* z;           ///< right side, then multipliers (nbar, lanes)
  const T* busy;  ///< 1: the lane is to move (lanes)
  T* worst;       ///< largest violation, as a share of what is allowed (lanes)
  T* relative;    ///< the same of the bar's length (lanes)
  T* largest;     ///< the same, nm (lanes)
  T* sum;         ///< of squared distances: tells of what is no number (lanes)

  const double* lengths;  ///< a bar's and 1 over it (nbar, 2)
  /// A violation times distance over length is measured exactly from here on (lanes).
  const T *relative_from, *largest_from;
  double *exact_relative, *exact_largest;  ///< (lanes)
};

template <class T>
struct NewtonBarsKernel {
  void (*look)(const NewtonBarsTask<T>&);  ///< where the bars are, and how far they are violated
  void (*step)(const NewtonBarsTask<T>&);  ///< one Newton step, after a look
  /// Largest violations in doubles, of what floats have come to, after a look.
  void (*measure)(const NewtonBarsTask<T>&);
  std::size_t lanes;
};

/// @param wide  a whole vector of lanes; else one
template <class T>
const NewtonBarsKernel<T>& newton_bars_kernel(bool wide);

const char* newton_bars_instructions();

}  // namespace ragdoll
