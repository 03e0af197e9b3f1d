// Lane sweep: the arithmetic of sweep_arithmetic.h on conformers side by side, one in each lane of
// the machine's vectors: the same operations in the same order, so that each lane ends with the
// bits that it would have alone. Private to the resolvers.

#pragma once
#include <cstddef>
#include <string>

#include "ordered_constraints.h"  // OrderedConstraints

namespace ragdoll {

/// What a sweep works on. Numbers of lanes are 1 or 0 where they tell yes or no.
template <class T>
struct LaneSweep {
  const OrderedConstraints<T>* constraints;
  T* x;               ///< (njoint, 3, lanes), aligned
  std::size_t lanes;  ///< a whole number of vectors

  const T* busy;  ///< the lanes that the sweep is for (lanes)
  T* corrected;   ///< set where something was (lanes)
  T* held;        ///< where something is violated that nothing can move (lanes)
  T* not_finite;  ///< where numbers ran out (lanes)
};

/// A pair of the contact rule as lanes look at it.
template <class T>
struct NearVisit {
  int p, q;
  T sure2;  ///< above this squared distance it is surely within tolerance
  double bound;
};

/// The sweeps, compiled for one instruction set.
template <class T>
struct LaneKernels {
  void (*bars_and_pairs)(const LaneSweep<T>&);
  void (*volumes)(const LaneSweep<T>&);
  /// The first of these pairs that could be violated in a busy lane, or count.
  /// suspects: set to 1 where it could be, to 0 elsewhere (lanes)
  std::size_t (*next_contact)(const LaneSweep<T>&, const NearVisit<T>* pairs, std::size_t from,
                              std::size_t count, T* suspects);
  /// largest2: the square of the furthest that a joint has moved (lanes)
  void (*furthest)(const T* x, const T* from, std::size_t joints, std::size_t lanes, T* largest2);
  std::size_t vector;        ///< lanes that one vector holds
  const char* instructions;  ///< "AVX3", ...
};

/// Of the best instruction set that the machine has.
const LaneKernels<float>& single_kernels();
const LaneKernels<double>& double_kernels();

template <class T>
const LaneKernels<T>& lane_kernels() {
  if constexpr (sizeof(T) == sizeof(float))
    return single_kernels();
  else
    return double_kernels();
}

}  // namespace ragdoll
