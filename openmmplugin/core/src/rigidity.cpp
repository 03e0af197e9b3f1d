#include "ragdoll/rigidity.h"

#include "ragdoll/dilution.h"  // Dilution

namespace ragdoll {

Rigidity analyse_rigidity(const BodyBarNetwork& network) {
  return Dilution(network, int(network.bonds.size())).at(0);
}

}  // namespace ragdoll
