// Whether a trajectory may and can be written where the caller wants it.
//
// SPDX-License-Identifier: MIT

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>

#include "files.h"
#include "layout.h"
#include "ragdoll/trajectory/writer.h"
#include "segments.h"

namespace fs = std::filesystem;

namespace ragdoll {
namespace {

// tries out that a file can be made under this name
void check_creatable(const std::string& path, const std::string& name) {
  const int file = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (file >= 0) {
    ::close(file);
    remove_file(name);
  } else if (errno != EEXIST) {
    throw TrajectoryUsageError(path + " cannot be written: " + system_reason(errno));
  }
}

void check_folder(const std::string& path) {
  const fs::path parent = fs::path(path).parent_path();
  const fs::path folder = parent.empty() ? fs::path(".") : parent;
  std::error_code error;
  if (!fs::exists(folder, error))
    throw TrajectoryUsageError(path + " cannot be written: there is no folder " + folder.string() +
                               "; make it first");
  if (!fs::is_directory(folder, error))
    throw TrajectoryUsageError(path + " cannot be written: " + folder.string() +
                               " is not a folder");
  if (::access(folder.c_str(), R_OK | W_OK | X_OK) != 0)
    throw TrajectoryUsageError(path + " cannot be written: " + system_reason(errno));
}

}  // namespace

void check_output(const std::string& path, bool force) {
  if (path.empty()) throw TrajectoryUsageError("a trajectory needs a file name");
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::is_directory(status))
    throw TrajectoryUsageError(path + " is a folder; give the name of a file in it");
  check_folder(path);
  if (fs::exists(status) && !fs::is_regular_file(status))
    throw TrajectoryUsageError(path + " is not a regular file; give another name");

  // what is there already
  if (fs::exists(fs::symlink_status(path, error)) && !force)
    throw TrajectoryUsageError(path + " exists already; give --force to replace it");
  const Leftovers old = leftovers_of(path);
  for (const std::vector<std::string>& names : {old.segments, old.parts})
    if (!names.empty() && !force)
      throw TrajectoryUsageError(names.front() + " is left from an interrupted run of " + path +
                                 "; move it away, or give --force to remove it");
  for (const std::string& segment : old.segments)
    if (!is_segment(segment))
      throw TrajectoryUsageError(segment + " is in the way of " + path +
                                 " and is not a segment of it; move it away");

  check_creatable(path, part_of(path));
  check_creatable(path, part_of(segment_path(path, 0)));
}

}  // namespace ragdoll
