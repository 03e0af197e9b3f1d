// Small files of the method for the tests, in a folder that removes itself.

#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "ragdoll/error.h"
#include "ragdoll/structure.h"

namespace ragdoll {

/// A new folder, gone with its scope.
class Folder {
 public:
  Folder();
  ~Folder();
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::string operator/(const std::string& name) const { return (path_ / name).string(); }

  /// Writes a file and returns its path.
  std::string write(const std::string& name, const std::string& text) const;

  /// Names of all that is in it, sorted.
  std::vector<std::string> names() const;

 private:
  std::filesystem::path path_;
};

std::string text_of_file(const std::string& path);

/// A structure file with these lines, from line 2 on, in its root.
std::string in_structure(const std::string& lines, const std::string& attributes = "");

/// Joints a, b, c and d at the corners of a square, bars a-b, b-c, c-d and d-a.
std::string square_text();
Structure square();

/// What `act` throws as Error; "" if it throws nothing.
template <class Act>
std::string error_of(Act act) {
  try {
    act();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

/// Every number of a structure as text that tells each double from every other.
std::string fingerprint(const Structure& structure);

}  // namespace ragdoll
