// What goes wrong with trajectory files, as one sentence that names the file.
//
// SPDX-License-Identifier: MIT

#pragma once
#include <stdexcept>  // std::runtime_error

namespace ragdoll {

/// A trajectory could not be written or read (disk full, unreadable file, ...).
class TrajectoryError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The caller asked for something impossible (the file exists already, no such folder, ...);
/// nothing has been written or removed.
class TrajectoryUsageError : public TrajectoryError {
 public:
  using TrajectoryError::TrajectoryError;
};

}  // namespace ragdoll
