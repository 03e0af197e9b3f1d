// Reads molecules from SMILES, SD, MOL and MOL2 files, one after the other.

#pragma once
#include <memory>
#include <optional>
#include <string>

namespace RDKit {
class RWMol;
}

namespace ragdoll {

/// One molecule of a file, or why it cannot be used.
struct MoleculeRecord {
  long number = 0;                    ///< place among the file's molecules, from 0
  long line = 1;                      ///< where it starts, from 1
  std::string title;                  ///< its name in the file, else "line 3" or "molecule 2"
  std::shared_ptr<RDKit::RWMol> mol;  ///< sanitized, atoms in the file's order; null: unusable
  std::string fault;                  ///< why it is null, a clause
};

/// A file of molecules, open; one record is in memory at a time.
class MoleculeReader {
 public:
  /// @param path  .smi, .smiles, .txt (SMILES and title a line; lines with # are skipped), .sdf,
  ///              .sd, .mol or .mol2
  /// @throw Error  if the file cannot be read or its name does not tell its format
  explicit MoleculeReader(const std::string& path);
  ~MoleculeReader();
  MoleculeReader(MoleculeReader&&) noexcept;
  MoleculeReader& operator=(MoleculeReader&&) noexcept;

  /// The next molecule; none at the end. One that RDKit cannot read has a fault.
  std::optional<MoleculeRecord> next();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Whether the name ends as that of a file of molecules.
bool names_molecule_file(const std::string& path);

/// A sanitized molecule; its explicit hydrogens become implicit, as RDKit has it.
/// @throw Error  that says why RDKit cannot read it
std::shared_ptr<RDKit::RWMol> molecule_of_smiles(const std::string& smiles);

}  // namespace ragdoll
