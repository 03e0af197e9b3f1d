// A file descriptor that is closed with its scope, and the system's own words.

#pragma once
#include <unistd.h>  // close

#include <string>
#include <system_error>  // generic_category

namespace ragdoll {

struct Descriptor {
  int number;

  explicit Descriptor(int n) : number(n) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (number >= 0) ::close(number);
  }
};

/// Why a system call failed: strerror(), for any number of threads.
inline std::string system_reason(int error) {
  return std::generic_category().message(error);
}

}  // namespace ragdoll
