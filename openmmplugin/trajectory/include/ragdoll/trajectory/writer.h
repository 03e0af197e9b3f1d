// Writes one HDF5 file that MDTraj loads as its own format and that is H5MD 1.1 as well.
//
// HDF5 never sees a disk: a file is built in memory, written beside its place as `.part`, synced
// and renamed. While frames arrive they go into segments, each a complete trajectory; close()
// merges them. A killed run therefore loses the frames since its last segment and nothing else.
//
//     out.h5            the trajectory, once close() has returned
//     out.000.h5 ...    its segments, until then
//
// SPDX-License-Identifier: MIT

#pragma once
#include <cstddef>
#include <memory>
#include <string>

#include "ragdoll/trajectory/error.h"
#include "ragdoll/trajectory/frame.h"
#include "ragdoll/trajectory/header.h"

namespace ragdoll {

/// How a trajectory is written. A segment ends as soon as one of its three bounds is reached.
struct TrajectoryOptions {
  bool force = false;           ///< replace an existing trajectory, remove its old segments
  double precision_nm = 0;      ///< largest error that rounding may make; 0 keeps every bit
  double segment_seconds = 2;   ///< a segment lasts this long, ...
  double segment_share = 0.05;  ///< ... or this share of the run so far, if that is longer
  std::size_t segment_bytes = std::size_t{32} << 20;  ///< positions and velocities in a segment
  std::size_t memory_bytes = std::size_t{512} << 20;  ///< larger files are merged on the disk
};

/// Refuses an output that could not be written later: an existing file or segment without `force`,
/// a missing or write-protected folder, a folder instead of a file.
/// @throw TrajectoryUsageError with one sentence that says what to do
void check_output(const std::string& path, bool force);

/// Appends frames to a new trajectory; threads take turns.
class TrajectoryWriter {
 public:
  /// @throw TrajectoryUsageError as check_output() does, or if the header contradicts itself
  TrajectoryWriter(std::string path, TrajectoryHeader header, TrajectoryOptions options = {});

  /// Without close(), keeps the finished segments and drops the frames after them.
  ~TrajectoryWriter();

  TrajectoryWriter(const TrajectoryWriter&) = delete;
  TrajectoryWriter& operator=(const TrajectoryWriter&) = delete;

  /// Adds a frame; ends the segment if it is due.
  /// @throw TrajectoryUsageError if the frame does not fit the header; it is not added
  /// @throw TrajectoryError if a segment cannot be written; its frames stay in memory
  void append(const Frame& frame);

  /// Makes the trajectory complete and removes the segments. Without a frame, writes nothing and
  /// leaves an older file as it was. Does nothing when called again.
  /// @throw TrajectoryError if there is no room; the sentence names the segments that are kept
  void close();

  /// Removes all that this writer has made; an older trajectory stays.
  void abandon();

  /// Frames appended so far.
  std::size_t frame_count() const;

  /// True after close() or abandon().
  bool closed() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ragdoll
