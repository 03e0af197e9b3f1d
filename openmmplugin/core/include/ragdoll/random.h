// Random: a small generator whose streams are addressed, not carried: (seed, stream, step) always
// gives the same numbers, so that a restart needs no generator state.

#pragma once
#include <cstdint>
#include <span>

namespace ragdoll {

/// What a stream is for, so that no two uses share numbers.
enum class RandomStream : std::uint64_t {
  perturbation = 1,
  order = 2,
  generate = 3,
  conformers = 4,
  record = 8,
};

/// xoshiro256++ (Blackman & Vigna 2019), seeded through splitmix64.
class Random {
 public:
  Random(std::uint64_t seed, RandomStream stream, std::uint64_t step);

  std::uint64_t next();
  double uniform();                      ///< [0, 1)
  std::uint64_t below(std::uint64_t n);  ///< [0, n), without bias
  double gaussian();  ///< mean 0, deviation 1 (Marsaglia's polar method); generated structures

  /// Normal numbers, mean 0 and deviation 1, several times as fast: the ziggurat of Marsaglia and
  /// Tsang (2000) with 256 layers, whose layer, sign and place come from bits of their own. Filling
  /// a span in parts gives the same numbers.
  void fill_normal(std::span<double> values);

 private:
  std::uint64_t state_[4];
  double spare_ = 0;
  bool has_spare_ = false;
};

/// The seed of molecule `record` (from 0) of a file that is run with `seed`: that of the run for
/// the first, so that a file of one molecule gives what the molecule alone does; others' are below
/// 2^63.
std::uint64_t record_seed(std::uint64_t seed, std::uint64_t record);

}  // namespace ragdoll
