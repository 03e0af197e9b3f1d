#include "ramachandran.h"

#include <algorithm>  // any_of
#include <array>

namespace ragdoll {
namespace {

using enum BackboneAtom;

constexpr std::array<RamachandranRow, 11> helix = {{{-60, -72, -56},
                                                    {-52, -84, -44},
                                                    {-44, -92, -44},
                                                    {-36, -100, -52},
                                                    {-28, -104, -56},
                                                    {-20, -112, -56},
                                                    {-12, -116, -64},
                                                    {-4, -120, -72},
                                                    {4, -120, -80},
                                                    {12, -120, -92},
                                                    {20, -120, -100}}};

constexpr std::array<RamachandranRow, 9> bridge = {{{28, -112, -88},
                                                    {36, -108, -84},
                                                    {44, -108, -84},
                                                    {52, -104, -80},
                                                    {60, -100, -80},
                                                    {68, -96, -80},
                                                    {76, -96, -80},
                                                    {84, -100, -80},
                                                    {92, -112, -80}}};

constexpr std::array<RamachandranRow, 10> strand = {{{100, -124, -84},
                                                     {108, -136, -76},
                                                     {116, -144, -64},
                                                     {124, -148, -52},
                                                     {132, -156, -48},
                                                     {140, -160, -52},
                                                     {148, -164, -56},
                                                     {156, -168, -60},
                                                     {164, -168, -64},
                                                     {172, -164, -128}}};

constexpr std::array<RamachandranRow, 9> left = {{{-12, 84, 92},
                                                  {-4, 76, 92},
                                                  {4, 68, 88},
                                                  {12, 64, 84},
                                                  {20, 60, 80},
                                                  {28, 52, 72},
                                                  {36, 48, 60},
                                                  {44, 44, 60},
                                                  {52, 44, 52}}};

// proline's ring leaves phi little room; what comes before it is kept out of the helix' upper part
// by its carbon delta
constexpr std::array<RamachandranRow, 5> proline_helix = {
    {{-52, -72, -48}, {-40, -80, -48}, {-24, -88, -52}, {-8, -96, -60}, {8, -100, -76}}};
constexpr std::array<RamachandranRow, 5> proline_strand = {
    {{116, -76, -56}, {132, -88, -52}, {148, -88, -52}, {164, -88, -56}, {176, -80, -60}}};
constexpr std::array<RamachandranRow, 5> before_proline_helix = {
    {{-60, -68, -56}, {-52, -76, -48}, {-44, -84, -48}, {-36, -88, -56}, {-24, -88, -60}}};

constexpr BackboneDistance at_least(BackboneAtom p, BackboneAtom q) {
  return {p, q, false};
}
constexpr BackboneDistance at_most(BackboneAtom p, BackboneAtom q) {
  return {p, q, true};
}

constexpr std::array<BackboneDistance, 6> helix_distances = {
    at_most(alpha_before, alpha_after), at_least(oxygen_before, nitrogen_after),
    at_least(oxygen_before, beta),      at_least(beta, oxygen),
    at_least(oxygen_before, oxygen),    at_least(alpha_before, nitrogen_after)};
constexpr std::array<BackboneDistance, 6> strand_distances = {
    at_least(nitrogen, nitrogen_after),      at_most(beta, oxygen),
    at_least(oxygen_before, oxygen),         at_least(oxygen_before, beta),
    at_least(oxygen_before, nitrogen_after), at_most(oxygen_before, oxygen)};
constexpr std::array<BackboneDistance, 4> left_distances = {
    at_least(oxygen_before, nitrogen_after), at_most(oxygen_before, beta), at_most(beta, oxygen),
    at_most(carbon_before, nitrogen_after)};
constexpr std::array<BackboneDistance, 9> joined_distances = {
    at_least(oxygen_before, beta),
    at_most(beta, oxygen),
    at_least(oxygen_before, nitrogen_after),
    at_most(oxygen_before, oxygen),
    at_least(oxygen_before, oxygen),
    at_most(carbon_before, oxygen),
    at_least(beta, oxygen),
    at_least(alpha_before, nitrogen_after),
    at_least(oxygen_before, alpha_after)};

}  // namespace

std::span<const RamachandranRow> rows_of(RamachandranMap map, RamachandranPart part) {
  if (part == RamachandranPart::left) {
    if (map == RamachandranMap::general) return left;
    return {};
  }
  const bool is_helix = part == RamachandranPart::helix;
  switch (map) {
    case RamachandranMap::proline:
      if (is_helix) return proline_helix;
      return proline_strand;
    case RamachandranMap::before_proline:
      if (is_helix) return before_proline_helix;
      return strand;
    default:
      if (is_helix) return helix;
      return strand;
  }
}

std::span<const RamachandranRow> bridge_rows() {
  return bridge;
}

std::vector<BackboneDistance> distances_for(std::span<const RamachandranPart> parts) {
  const auto has = [&](RamachandranPart part) {
    return std::find(parts.begin(), parts.end(), part) != parts.end();
  };
  std::vector<BackboneDistance> distances;
  const auto take = [&](const auto& more) {
    for (const BackboneDistance& d : more) {
      const auto same = [&](const BackboneDistance& other) {
        return other.p == d.p && other.q == d.q && other.upper == d.upper;
      };
      if (std::none_of(distances.begin(), distances.end(), same)) distances.push_back(d);
    }
  };
  const bool joined = has(RamachandranPart::helix) && has(RamachandranPart::strand);
  if (joined) take(joined_distances);
  if (has(RamachandranPart::helix) && !joined) take(helix_distances);
  if (has(RamachandranPart::strand) && !joined) take(strand_distances);
  if (has(RamachandranPart::left)) take(left_distances);
  return distances;
}

}  // namespace ragdoll
