// Network: a framework with the positions that satisfy it, and the breaks that are resolved.

#pragma once
#include <memory>
#include <string>
#include <vector>

#include "ragdoll/framework.h"  // Framework
#include "ragdoll/molecule.h"   // Molecule
#include "ragdoll/tolerance.h"  // Tolerance

namespace benchmark {

using Positions = std::vector<ragdoll::Vec3>;

struct Network {
  std::string name;  ///< "bonds", "molecule", ...
  std::shared_ptr<const ragdoll::Framework> framework;
  Positions positions;  ///< nm (njoint)
};

/// Bars alone, masses 1.
Network network_of_bars(std::string name, Positions positions, std::vector<ragdoll::Bar> bars);

/// Bonds alone.
Network network_of_bonds(const ragdoll::Molecule& molecule);

/// What build_framework makes: bonds, 1-3 and planar bars, volumes.
Network network_of_molecule(const ragdoll::Molecule& molecule, bool contacts);

/// Gaussian displacements of every joint. @param deviation  nm for each coordinate
std::vector<Positions> breaks_of(const Network& network, double deviation, int count,
                                 std::uint64_t first_step = 0);

/// How far constraints are violated, looked at here and not by a solver: the worst violation over
/// what the tolerance allows, so that 1 is just satisfied. Contacts by looking at every pair.
/// Infinity for NaN.
double worst_excess(const ragdoll::Framework& framework, const Positions& positions,
                    ragdoll::Tolerance tolerance, bool bars_alone = false);

}  // namespace benchmark
