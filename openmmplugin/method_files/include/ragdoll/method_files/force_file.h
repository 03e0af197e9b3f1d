// Force files: one force a step, and how each is resolved.

#pragma once
#include <string>
#include <vector>

#include "ragdoll/method_files/files.h"  // Warnings, WriteOptions
#include "ragdoll/structure.h"           // ForceSet, Structure

namespace ragdoll {

/// Forces whose joints are known by their ids alone.
struct NamedForces {
  std::vector<std::string> ids;  ///< each joint once, as the file first names it
  ForceSet set;                  ///< Force::joint is an index into `ids`
};

/// @throw Error      on what a force file must not hold, a joint that the structure does not have
/// @throw FileError  if reading breaks off
ForceSet read_forces(const std::string& path, const Structure& structure,
                     Warnings* warnings = nullptr);

/// Without a structure to look the joints up in.
NamedForces read_forces(const std::string& path, Warnings* warnings = nullptr);

/// @throw Error      on forces that could not be read back, or if the file is there already
/// @throw FileError  if writing breaks off; nothing is left behind
void write_forces(const std::string& path, const Structure& structure, const ForceSet& forces,
                  const WriteOptions& options = {});

}  // namespace ragdoll
