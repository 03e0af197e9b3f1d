// Files that are either complete or not there: written as NAME.part, synced, renamed.
//
// SPDX-License-Identifier: MIT

#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace ragdoll {

/// The name under which a file is written before it is complete.
std::string part_of(const std::string& path);

/// Why the last system call failed, in words.
std::string system_reason(int error);

/// Checks that a file of `size` bytes fits beside `path`.
/// @throw TrajectoryError "PATH cannot be written: No space left on device"
void check_room(const std::string& path, std::uintmax_t size);

/// Writes a whole file, or leaves nothing.
/// @throw TrajectoryError worded as by check_room()
void write_file(const std::string& path, std::span<const std::byte> content);

/// Sets blocks aside behind the end of the .part file, where the file system can: while the file
/// grows into them, it cannot run out of space.
/// @throw TrajectoryError worded as by check_room()
void reserve_room(const std::string& path, std::uintmax_t size);

/// Makes the .part file permanent under its final name.
/// @throw TrajectoryError
void publish(const std::string& path);

/// Removes a file that may or may not be there; never fails.
void remove_file(const std::string& path) noexcept;

}  // namespace ragdoll
