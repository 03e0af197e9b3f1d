// One HDF5 file of many trajectories, such as the conformers of many molecules. Each is a group
// /molecules/NAME that is laid out as a trajectory file is; the root's /ragdoll tells of all.
//
// SPDX-License-Identifier: MIT

#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "ragdoll/trajectory/error.h"
#include "ragdoll/trajectory/frame.h"
#include "ragdoll/trajectory/header.h"

namespace ragdoll {

/// Writes a collection in one go. The file appears when it is closed, and not before.
class CollectionWriter {
 public:
  /// @param about  its attributes, texts and arrays go to the root's /ragdoll; the rest is not used
  /// @param expected_bytes  set aside on the disk, so that a full one is noticed now; 0: nothing
  /// @throw TrajectoryUsageError as check_output() does
  /// @throw TrajectoryError if there is no room
  CollectionWriter(std::string path, const TrajectoryHeader& about, bool force,
                   std::uintmax_t expected_bytes);

  /// Without close(), removes what was written.
  ~CollectionWriter();

  CollectionWriter(const CollectionWriter&) = delete;
  CollectionWriter& operator=(const CollectionWriter&) = delete;

  /// Adds a trajectory without boxes and velocities.
  /// @param name  of its group; no slash, unique
  /// @throw TrajectoryUsageError if frames do not fit the header or the name is taken
  /// @throw TrajectoryError if it cannot be written
  void add(const std::string& name, const TrajectoryHeader& header, std::span<const Frame> frames);

  /// Completes the file.
  /// @throw TrajectoryError if it cannot be written
  void close();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Names of the trajectories in a collection, sorted; none in a file of one trajectory.
/// @throw TrajectoryUsageError if there is no such file
/// @throw TrajectoryError if it is no HDF5 file
std::vector<std::string> names_in_collection(const std::string& path);

}  // namespace ragdoll
