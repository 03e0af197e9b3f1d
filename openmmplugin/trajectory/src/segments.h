// Names of a trajectory's segments: out.h5 is gathered in out.000.h5, out.001.h5, ...
//
// SPDX-License-Identifier: MIT

#pragma once
#include <cstddef>
#include <string>
#include <vector>

namespace ragdoll {

/// Name of segment `number` of the trajectory `path`.
std::string segment_path(const std::string& path, std::size_t number);

/// What an earlier run has left beside `path`, sorted: segments, and files not completed.
struct Leftovers {
  std::vector<std::string> segments;
  std::vector<std::string> parts;
};

/// @throw std::filesystem::filesystem_error if the folder cannot be listed
Leftovers leftovers_of(const std::string& path);

}  // namespace ragdoll
