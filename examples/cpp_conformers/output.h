// Where conformers go: an SD file, or HDF5.

#pragma once
#include <ragdoll/chemistry/molecule_reader.h>  // MoleculeRecord
#include <ragdoll/conformers.h>                 // Conformers
#include <memory>

#include "options.h"

namespace RDKit {
class RWMol;
}

/// Conformers of one molecule.
struct Made {
  const ragdoll::MoleculeRecord& record;
  RDKit::RWMol& start;  ///< with all hydrogens
  const ragdoll::Molecule& molecule;
  const ragdoll::Conformers& conformers;
  std::uint64_t seed;  ///< of this molecule
};

/// A file that appears when it is complete.
class Output {
 public:
  virtual ~Output() = default;
  virtual void add(const Made& made) = 0;
  virtual void close() = 0;
};

/// @throw UsageError  if the output exists and is not to be replaced, or cannot be there
std::unique_ptr<Output> open_output(const Options& options);
