// One frame of a trajectory, seen in the caller's memory.
//
// SPDX-License-Identifier: MIT

#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>

namespace ragdoll {

/// The three box vectors a, b, c in nm, one after the other, first component first.
using BoxVectors = std::array<double, 9>;

/// What happens in one frame. The spans are read during the call that takes the frame only.
struct Frame {
  std::span<const float> positions;     ///< x y z of each atom, nm                    (3 N)
  double time = 0;                      ///< ps
  std::int64_t step = 0;                ///< integration step
  std::span<const double> observables;  ///< in the order of the header                (O)
  std::optional<BoxVectors> box;        ///< present if and only if the header is periodic
  std::span<const float> velocities;    ///< nm/ps; empty unless the header says so    (3 N)
};

}  // namespace ragdoll
