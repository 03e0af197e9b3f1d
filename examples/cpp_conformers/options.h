// What the command line asks for.

#pragma once
#include <cstdint>
#include <stdexcept>
#include <string>

/// A request that cannot be met: the program ends with exit code 2.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Options {
  std::string input;   ///< a file .smi, .sdf, .mol2, ..., or a SMILES
  std::string output;  ///< .sdf or .h5
  int count = 50;      ///< conformers of each molecule
  std::uint64_t seed = 0;
  bool embed = false;  ///< embed also where the input has coordinates
  bool force = false;  ///< replace an existing output
  bool help = false;
};

extern const char* const usage;

/// @throw UsageError  with one sentence
Options read_options(int count, char** words);
