// SPDX-License-Identifier: MIT

#include "files.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>

#include "ragdoll/trajectory/error.h"

namespace ragdoll {
namespace {

// A file descriptor that is closed with its scope.
struct Descriptor {
  int number;

  explicit Descriptor(int n) : number(n) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (number >= 0) ::close(number);
  }
};

[[noreturn]] void fail(const std::string& path, int error) {
  remove_file(part_of(path));
  throw TrajectoryError(path + " cannot be written: " + system_reason(error));
}

std::string folder_of(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  return folder.empty() ? "." : folder;
}

// Beyond this limit write() would not only fail but send SIGXFSZ, which ends a program that does
// not ignore it.
bool within_size_limit(std::uintmax_t size) {
  rlimit limit{};
  return getrlimit(RLIMIT_FSIZE, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY ||
         size <= limit.rlim_cur;
}

}  // namespace

std::string part_of(const std::string& path) {
  return path + ".part";
}

std::string system_reason(int error) {
  return std::generic_category().message(error);
}

void remove_file(const std::string& path) noexcept {
  ::unlink(path.c_str());
}

void check_room(const std::string& path, std::uintmax_t size) {
  if (!within_size_limit(size)) fail(path, EFBIG);

  struct statvfs disk {};
  if (statvfs(folder_of(path).c_str(), &disk) != 0) return;
  const auto blocks = ::geteuid() == 0 ? disk.f_bfree : disk.f_bavail;
  if (size > static_cast<std::uintmax_t>(blocks) * disk.f_frsize) fail(path, ENOSPC);
}

void write_file(const std::string& path, std::span<const std::byte> content) {
  check_room(path, content.size());
  {
    const Descriptor part(
        ::open(part_of(path).c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
    if (part.number < 0) fail(path, errno);
    while (!content.empty()) {
      const ssize_t written = ::write(part.number, content.data(), content.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) fail(path, errno);
      content = content.subspan(static_cast<std::size_t>(written));
    }
  }
  publish(path);
}

void reserve_room([[maybe_unused]] const std::string& path, [[maybe_unused]] std::uintmax_t size) {
#ifdef __linux__
  const Descriptor part(::open(part_of(path).c_str(), O_WRONLY | O_CLOEXEC));
  if (part.number < 0) fail(path, errno);
  if (::fallocate(part.number, FALLOC_FL_KEEP_SIZE, 0, static_cast<off_t>(size)) != 0 &&
      errno != EOPNOTSUPP && errno != ENOSYS)
    fail(path, errno);
#endif
}

void publish(const std::string& path) {
  const std::string part = part_of(path);
  {
    const Descriptor file(::open(part.c_str(), O_WRONLY | O_CLOEXEC));
    if (file.number < 0 || ::fsync(file.number) != 0) fail(path, errno);
  }
  if (::rename(part.c_str(), path.c_str()) != 0) fail(path, errno);

  // the new name should survive a power cut too; some file systems cannot promise it
  const Descriptor folder(::open(folder_of(path).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (folder.number >= 0) ::fsync(folder.number);
}

}  // namespace ragdoll
