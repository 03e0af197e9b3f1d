// TorsionTerm: how much an angle of rotation about a bond is liked.

#pragma once
#include <array>

namespace ragdoll {

/// E(phi) = sum over k = 1..6 of amplitude_k (1 + sign_k cos(k phi)), phi the torsion a-b-c-d: the
/// form of the experimental torsion preferences of Riniker and Landrum (J. Chem. Inf. Model. 55,
/// 2562, 2015).
struct TorsionTerm {
  int a = 0, b = 0, c = 0, d = 0;     ///< atoms
  std::array<double, 6> amplitude{};  ///< kJ/mol
  std::array<int, 6> sign{};          ///< 1 or -1; 0 where the amplitude is 0
};

/// kJ/mol. @param phi  rad
double energy_of(const TorsionTerm& term, double phi);

}  // namespace ragdoll
