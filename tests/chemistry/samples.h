// What the tests of chemistry share.

#pragma once
#include <GraphMol/ROMol.h>
#include <GraphMol/RWMol.h>
#include <GraphMol/SmilesParse/SmilesParse.h>
#include <GraphMol/Substruct/SubstructMatch.h>
#include <stdlib.h>  // mkdtemp

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "ragdoll/build_framework.h"
#include "ragdoll/chemistry/molecule_reader.h"
#include "ragdoll/chemistry/rdkit_molecule.h"
#include "ragdoll/chemistry/start.h"

namespace ragdoll {

/// A molecule with hydrogens and one embedded conformer.
inline std::shared_ptr<RDKit::RWMol> embedded(const std::string& smiles, std::uint64_t seed = 7) {
  return make_start(*molecule_of_smiles(smiles), {.seed = seed, .embed = true}).mol;
}

inline Framework framework_of(const RDKit::ROMol& mol) {
  return build_framework(molecule_from_rdkit(mol));
}

/// The atoms of the first match of a SMARTS; empty where there is none.
inline std::vector<int> match(const RDKit::ROMol& mol, const std::string& smarts) {
  const std::unique_ptr<RDKit::ROMol> query(RDKit::SmartsToMol(smarts));
  RDKit::MatchVectType found;
  std::vector<int> atoms;
  if (RDKit::SubstructMatch(mol, *query, found))
    for (const auto& [in_query, atom] : found) atoms.push_back(atom);
  return atoms;
}

inline bool are_bonded(const Framework& framework, int p, int q) {
  for (const Graph::Link& link : framework.bond_graph().links(p))
    if (link.other == q) return true;
  return false;
}

/// Whether planar bars go across the bond bc.
inline bool is_planar(const Framework& framework, int b, int c) {
  for (const Bar& bar : framework.bars())
    if (bar.kind == BarKind::planar &&
        ((are_bonded(framework, bar.p, b) && are_bonded(framework, c, bar.q)) ||
         (are_bonded(framework, bar.p, c) && are_bonded(framework, b, bar.q))))
      return true;
  return false;
}

/// Volumes of a kind that have the joint as their centre: within their four, or bonded to the three
/// others.
inline int volumes_about(const Framework& framework, int joint, VolumeKind kind) {
  int count = 0;
  for (std::size_t k = 0; k < framework.volumes().size(); ++k) {
    const Volume& v = framework.volumes()[k];
    const bool is_first = v.a == joint && are_bonded(framework, joint, v.b) &&
                          are_bonded(framework, joint, v.c) && are_bonded(framework, joint, v.d);
    count += v.kind == kind && (framework.centres()[k] == joint || is_first);
  }
  return count;
}

/// A new folder, gone with its scope.
class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "ragdoll.XXXXXX").string();
    if (mkdtemp(name.data())) path_ = name;
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  /// Writes a file. @return its path
  std::string file(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name) << text;
    return (path_ / name).string();
  }

 private:
  std::filesystem::path path_;
};

}  // namespace ragdoll
