// Reads what TrajectoryWriter wrote, and files of MDTraj's HDF5 format.
//
// SPDX-License-Identifier: MIT

#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "ragdoll/trajectory/error.h"
#include "ragdoll/trajectory/frame.h"
#include "ragdoll/trajectory/header.h"

namespace ragdoll {

/// An open trajectory. Frames are numbered from 0; T is their number, N that of the atoms.
/// Every function throws TrajectoryError if the file turns out to be damaged, and
/// TrajectoryUsageError for a frame or observable that does not exist.
class TrajectoryReader {
 public:
  /// @param molecule  name of a trajectory in a collection (see CollectionWriter); empty: the file
  /// @throw TrajectoryUsageError if there is no such file or molecule, or the file is a collection
  /// @throw TrajectoryError if it cannot be read, is damaged or holds no trajectory
  explicit TrajectoryReader(std::string path, const std::string& molecule = "");
  ~TrajectoryReader();

  TrajectoryReader(const TrajectoryReader&) = delete;
  TrajectoryReader& operator=(const TrajectoryReader&) = delete;

  std::size_t atom_count() const;   ///< N
  std::size_t frame_count() const;  ///< T
  bool periodic() const;            ///< the frames have boxes
  bool has_velocities() const;      ///< the frames have velocities

  /// The header as it was given to the writer, with its observables sorted by name.
  TrajectoryHeader header() const;

  /// Reads positions of frames first, first + 1, ... in nm; out has 3 N floats a frame.
  void read_positions(std::size_t first, std::span<float> out) const;

  /// Reads velocities in nm/ps, shaped as positions.
  void read_velocities(std::size_t first, std::span<float> out) const;

  /// Positions of one frame in nm (3 N).
  std::vector<float> positions(std::size_t frame) const;

  std::vector<double> times() const;        ///< ps; stored as float32        (T)
  std::vector<std::int64_t> steps() const;  ///< frame numbers, if not stored (T)
  std::vector<BoxVectors> boxes() const;    ///< nm; empty unless periodic    (T)

  /// One number a frame: doubles or 64-bit integers (T).
  Values observable(const std::string& name) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ragdoll
