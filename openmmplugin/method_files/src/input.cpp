#include "input.h"

#include <fcntl.h>     // open
#include <sys/stat.h>  // fstat
#include <unistd.h>    // read, close

#include <algorithm>  // copy_n, max
#include <cerrno>

#include "descriptor.h"                  // Descriptor, system_reason
#include "ragdoll/error.h"               // Error
#include "ragdoll/method_files/files.h"  // FileError

namespace ragdoll {

Buffer read_file(const std::string& path) {
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  struct stat status {};
  if (file.number < 0 || ::fstat(file.number, &status) != 0)
    throw Error(path + " cannot be read: " + system_reason(errno));
  if (S_ISDIR(status.st_mode)) throw Error(path + " is a folder, not a file");
  if (!S_ISREG(status.st_mode) && !S_ISFIFO(status.st_mode))
    throw Error(path + " is neither a file nor a pipe");

  // one byte more than the file has: read() then tells its end without a larger buffer
  Buffer buffer;
  std::size_t capacity = std::max<std::size_t>(std::size_t(status.st_size) + 1, 1 << 16);
  buffer.bytes = std::make_unique_for_overwrite<char[]>(capacity);
  while (true) {
    const ssize_t count =
        ::read(file.number, buffer.bytes.get() + buffer.size, capacity - buffer.size);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) throw FileError(path + " cannot be read: " + system_reason(errno));
    if (count == 0) return buffer;
    buffer.size += std::size_t(count);
    if (buffer.size < capacity) continue;
    capacity *= 2;
    auto larger = std::make_unique_for_overwrite<char[]>(capacity);
    std::copy_n(buffer.bytes.get(), buffer.size, larger.get());
    buffer.bytes = std::move(larger);
  }
}

}  // namespace ragdoll
