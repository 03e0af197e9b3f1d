#include "ragdoll/random.h"

#include <bit>    // rotl
#include <cmath>  // sqrt, log

namespace ragdoll {
namespace {

/// splitmix64 (Steele, Lea & Flood 2014): spreads an address over 64 bits.
std::uint64_t splitmix(std::uint64_t& state) {
  std::uint64_t z = (state += 0x9e3779b97f4a7c15ull);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  return z ^ (z >> 31);
}

}  // namespace

Random::Random(std::uint64_t seed, RandomStream stream, std::uint64_t step) {
  // chain the three numbers through splitmix, so that neighbouring addresses share nothing
  std::uint64_t state = seed;
  state = splitmix(state) ^ static_cast<std::uint64_t>(stream);
  state = splitmix(state) ^ step;
  for (std::uint64_t& word : state_) word = splitmix(state);
}

std::uint64_t Random::next() {
  const std::uint64_t result = std::rotl(state_[0] + state_[3], 23) + state_[0];
  const std::uint64_t t = state_[1] << 17;
  state_[2] ^= state_[0];
  state_[3] ^= state_[1];
  state_[1] ^= state_[2];
  state_[0] ^= state_[3];
  state_[2] ^= t;
  state_[3] = std::rotl(state_[3], 45);
  return result;
}

double Random::uniform() {
  return double(next() >> 11) * 0x1.0p-53;
}

std::uint64_t Random::below(std::uint64_t n) {
  // refuse the few values that would favour small results; they are all above most - n
  constexpr std::uint64_t most = ~std::uint64_t{0};
  std::uint64_t value = next();
  if (value > most - n)
    while (value >= most - most % n) value = next();
  return value % n;
}

double Random::gaussian() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  double u, v, s;
  do {
    u = 2 * uniform() - 1;
    v = 2 * uniform() - 1;
    s = u * u + v * v;
  } while (s >= 1 || s == 0);
  const double factor = std::sqrt(-2 * std::log(s) / s);
  spare_ = v * factor;
  has_spare_ = true;
  return u * factor;
}

}  // namespace ragdoll
