// What the readers and writers of the method's files have in common.
//
// A reader refuses what formats.md does not allow with an Error of one sentence: "FILE, line 3: the
// bar joins b to itself". Attributes that it does not know are passed over with a warning.
// A writer makes the whole file or none: it writes FILE.part and renames it. Files that come back
// from the seed are not synced to disk, so that a set of thousands is written at once.

#pragma once
#include <stdexcept>
#include <string>
#include <vector>

namespace ragdoll {

/// The operating system failed, in the middle of reading or writing: a full or broken disk.
class FileError : public std::runtime_error {
 public:
  explicit FileError(const std::string& sentence) : std::runtime_error(sentence) {}
};

/// One sentence for each attribute that an element should not have, with its first line; some
/// twenty at most.
using Warnings = std::vector<std::string>;

struct WriteOptions {
  bool force = false;  ///< replaces a file that is there
  int digits = 0;      ///< significant digits; 0: the fewest that read back exactly (17 always do)
};

}  // namespace ragdoll
