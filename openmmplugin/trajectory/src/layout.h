// Where everything lies in a trajectory file, written once for whole files and segments.
//
//     /coordinates  /time  /topology          MDTraj
//     /particles/trajectory, /observables     H5MD, hard-linked to the same data
//     /parameters/vmd_structure               VMD
//     /ragdoll                                ours
//
// SPDX-License-Identifier: MIT

#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "hdf5.h"
#include "ragdoll/trajectory/frame.h"
#include "ragdoll/trajectory/header.h"

namespace ragdoll {

constexpr std::int64_t kFormatVersion = 1;
constexpr const char* kFormatVersionName = "format_version";
constexpr const char* kSegmentName = "segment";  ///< attribute of /ragdoll in segments only

/// What is small in frames: all of it stays in memory, positions and velocities do not.
struct FrameTable {
  std::vector<float> times;                      ///< ps                       (T)
  std::vector<std::int64_t> steps;               ///<                          (T)
  std::vector<std::vector<double>> observables;  ///< one list an observable   (O, T)
  std::vector<BoxVectors> boxes;                 ///< empty unless periodic    (T)

  std::size_t size() const { return steps.size(); }

  /// The frames from `first` on.
  FrameTable since(std::size_t first) const;
};

/// Writes all but positions and velocities, for which it leaves room: /coordinates, /velocities.
/// `file` is a file, or a group that is laid out as a file; so it is in the functions below.
void write_layout(hid_t file, const TrajectoryHeader& header, const FrameTable& frames,
                  std::optional<std::int64_t> segment);

/// Writes /ragdoll alone: the header's attributes, texts and arrays.
void write_own(hid_t file, const TrajectoryHeader& header, std::optional<std::int64_t> segment);

/// Fills /coordinates or /velocities from memory (3 N floats a frame).
void write_frames(hid_t file, const char* name, const std::vector<float>& values);

/// Copies a segment's /coordinates or /velocities as compressed, to the frames from `first` on.
void copy_frames(hid_t segment, hid_t file, const char* name, std::size_t first);

/// Bytes that /coordinates or /velocities take in the file, compressed.
std::size_t stored_bytes(hid_t file, const char* name);

/// True if the file at `path` can be read and says that it is a segment.
bool is_segment(const std::string& path);

}  // namespace ragdoll
