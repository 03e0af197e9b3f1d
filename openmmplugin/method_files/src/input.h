// A file as one buffer.

#pragma once
#include <cstddef>
#include <memory>
#include <string>

namespace ragdoll {

struct Buffer {
  std::unique_ptr<char[]> bytes;
  std::size_t size = 0;
};

/// Reads a regular file or a pipe; devices, some of which never end, are refused.
/// @throw Error if there is no such file to read, FileError if reading breaks off
Buffer read_file(const std::string& path);

}  // namespace ragdoll
