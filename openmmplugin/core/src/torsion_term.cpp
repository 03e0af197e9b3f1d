#include "ragdoll/torsion_term.h"

#include <cmath>  // cos

namespace ragdoll {

double energy_of(const TorsionTerm& term, double phi) {
  double energy = 0;
  for (std::size_t k = 0; k < term.amplitude.size(); ++k)
    energy += term.amplitude[k] * (1 + term.sign[k] * std::cos(double(k + 1) * phi));
  return energy;
}

}  // namespace ragdoll
