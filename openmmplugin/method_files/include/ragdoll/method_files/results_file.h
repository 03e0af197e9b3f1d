// results.xml: the index of a set, which names every file of it.
//
//   <results version="1" seed="7">
//     <structure class="1-cycle" path="1-cycle/001/structure.xml">
//       <order path="1-cycle/001/order.xml"/>
//       <forces path="1-cycle/001/forces/01.xml"/>
//       <technique order="bfs_cycle" weighting=".5/.5" folder="1-cycle/001/techniques/…"/>
//     </structure>
//   </results>
//
// All paths are relative to the folder of results.xml and lead no higher.

#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "ragdoll/method_files/files.h"  // Warnings, WriteOptions

namespace ragdoll {

struct ResultTechnique {
  std::string folder;
  std::string order = {}, weighting = {};  ///< "bfs_cycle", ".5/.5"; empty: not stated
};

struct ResultStructure {
  std::string class_name, structure;  ///< "1-cycle", path of structure.xml
  std::string order = {};             ///< path of order.xml; empty: none
  std::vector<std::string> forces = {};
  std::vector<ResultTechnique> techniques = {};
};

struct ResultSet {
  std::uint64_t seed = 0;
  std::vector<ResultStructure> structures = {};
};

/// @throw Error      on what results.xml must not hold: a path that is absolute or leads out of the
///                   set, two structures of one path
/// @throw FileError  if reading breaks off
ResultSet read_results(const std::string& path, Warnings* warnings = nullptr);

/// @throw Error      on results that could not be read back, or if the file is there already
/// @throw FileError  if writing breaks off; nothing is left behind
void write_results(const std::string& path, const ResultSet& results,
                   const WriteOptions& options = {});

}  // namespace ragdoll
