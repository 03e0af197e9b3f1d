// What a trajectory says once: the molecule, the names of its observables and the project's own
// data. Frames come after it, one by one.
//
// SPDX-License-Identifier: MIT

#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <variant>
#include <vector>

namespace ragdoll {

/// Values of one type, row after row.
using Values =
    std::variant<std::vector<double>, std::vector<std::int64_t>, std::vector<std::int32_t>>;

/// An array of any shape; an empty shape is one number.
struct Array {
  std::vector<std::size_t> shape;  ///< extent of each dimension
  Values values;                   ///< product of the extents many

  bool operator==(const Array&) const = default;
};

/// A small fact, kept as an HDF5 attribute.
using Attribute = std::variant<std::string, std::int64_t, double>;

/// A number that every frame carries, such as `iterations` or `residual`.
struct Observable {
  std::string name;      ///< no slash; unique in a trajectory
  bool integer = false;  ///< stored as int64 instead of float64
  std::string unit;      ///< H5MD unit, e.g. "nm"; empty for a pure number

  bool operator==(const Observable&) const = default;
};

/// Everything in a trajectory that does not change from frame to frame.
struct TrajectoryHeader {
  std::int64_t atom_count = 0;               ///< N, at least 1
  std::string topology_json;                 ///< MDTraj's JSON form; empty: no topology is stored
  std::vector<std::int32_t> bonds;           ///< pairs of atom indices from 0        (2 B)
  std::vector<std::int32_t> atomic_numbers;  ///< 0 for a joint that is no atom       (N, or empty)
  bool periodic = false;                     ///< every frame has a box
  bool velocities = false;                   ///< every frame has velocities
  std::vector<Observable> observables;       ///< order of Frame::observables         (O)

  std::string program = "ragdoll";  ///< what wrote the file
  std::string program_version;      ///< its version
  std::string author;               ///< who ran it; may be empty

  // The group /ragdoll. A slash in a name makes a group: "framework/bars". The attribute names
  // `format_version` and `segment` belong to the writer.
  std::map<std::string, Attribute> attributes;  ///< seed, version, input_hash, ...
  std::map<std::string, std::string> texts;     ///< long texts, such as `parameters` (JSON)
  std::map<std::string, Array> arrays;          ///< framework/bars, framework/bar_lengths, ...

  bool operator==(const TrajectoryHeader&) const = default;
};

}  // namespace ragdoll
