// TorsionTerm: what a torsion prefers, as a Fourier series in its angle.

#pragma once
#include <array>

namespace ragdoll {

/// E(phi) = sum over k = 1..6 of amplitude[k - 1] (1 + sign[k - 1] cos(k phi)), phi the torsion of
/// the atoms a, b, c, d.
struct TorsionTerm {
  int a = 0, b = 0, c = 0, d = 0;
  std::array<double, 6> amplitude{};  ///< kJ/mol
  std::array<int, 6> sign{};          ///< 1 or -1
};

}  // namespace ragdoll
