// Structure files: joints, bars, tethers and contacts.

#pragma once
#include <string>

#include "ragdoll/method_files/files.h"  // Warnings, WriteOptions
#include "ragdoll/structure.h"           // Structure

namespace ragdoll {

/// Bars without a length take the present distance. `type` stays empty; all bars are of kind bond.
/// The elements may come in any order, bars before their joints too.
/// @throw Error      on what a structure file must not hold, or if there is no such file
/// @throw FileError  if reading breaks off
Structure read_structure(const std::string& path, Warnings* warnings = nullptr);

/// What read_structure() gives back exactly; the kinds of the bars and `type` are not in the file.
/// @throw Error      on a structure that could not be read back, or if the file is there already
/// @throw FileError  if writing breaks off; nothing is left behind
void write_structure(const std::string& path, const Structure& structure,
                     const WriteOptions& options = {});

}  // namespace ragdoll
