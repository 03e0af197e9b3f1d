#include "ragdoll/random.h"

#include <array>
#include <bit>    // rotl, bit_cast
#include <cmath>  // sqrt, log, exp

namespace ragdoll {
namespace {

/// splitmix64 (Steele, Lea & Flood 2014): spreads an address over 64 bits.
std::uint64_t splitmix(std::uint64_t& state) {
  std::uint64_t z = (state += 0x9e3779b97f4a7c15ull);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  return z ^ (z >> 31);
}

/// Layers of equal area under exp(-x^2/2), x >= 0, the widest first. Layer i reaches from 0 to
/// right[i], and lies wholly under the curve up to right[i + 1]. The first is the one that holds
/// the tail: its width is that of a rectangle of the same area.
struct Ziggurat {
  static constexpr int layers = 256;
  static constexpr double tail = 3.6541528853610088;    ///< where the tail starts
  static constexpr double area = 0.004928673233974658;  ///< of each layer
  std::array<double, layers + 1> right, height;         ///< height: of the curve at right

  Ziggurat() {
    const auto curve = [](double x) { return std::exp(-0.5 * x * x); };
    right[0] = area / curve(tail);
    right[1] = tail;
    height[0] = 0;
    height[1] = curve(tail);
    for (std::size_t i = 2; i < layers; ++i) {
      height[i] = height[i - 1] + area / right[i - 1];
      right[i] = std::sqrt(-2 * std::log(height[i]));
    }
    right[layers] = 0;
    height[layers] = 1;
  }
};
const Ziggurat ziggurat;

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

void Random::fill_normal(std::span<double> values) {
  // a copy of the state stays in registers
  Random random = *this;
  const Ziggurat& z = ziggurat;
  for (double& value : values) {
    while (true) {
      const std::uint64_t word = random.next();
      const std::size_t layer = word % Ziggurat::layers;
      double x = double(word >> 11) * 0x1.0p-53 * z.right[layer];
      bool inside = x < z.right[layer + 1];
      if (!inside) [[unlikely]] {
        if (layer == 0) {
          // the tail beyond, by Marsaglia (1964)
          double beyond, other;
          do {
            beyond = -std::log(1 - random.uniform()) / Ziggurat::tail;
            other = -std::log(1 - random.uniform());
          } while (2 * other < beyond * beyond);
          x = Ziggurat::tail + beyond;
          inside = true;
        } else {
          // the corner of the layer that the curve cuts
          const double y =
              z.height[layer] + random.uniform() * (z.height[layer + 1] - z.height[layer]);
          inside = y < std::exp(-0.5 * x * x);
        }
      }
      if (inside) {
        // the sign is a bit, because a branch would be guessed wrong half the time
        value = std::bit_cast<double>(std::bit_cast<std::uint64_t>(x) | (word & 256) << 55);
        break;
      }
    }
  }
  *this = random;
}

std::uint64_t record_seed(std::uint64_t seed, std::uint64_t record) {
  return record == 0 ? seed : Random(seed, RandomStream::record, record).next() >> 1;
}

}  // namespace ragdoll
