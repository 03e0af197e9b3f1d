// What a System adds to a framework: masses, particles that do not move, constraints.

#pragma once
#include <openmm/System.h>

#include <memory>

#include "ragdoll/framework.h"  // Framework

namespace ragdoll {

/// The framework that a step resolves. Masses are the System's; joints of mass 0 are fixed beside
/// those that the framework fixes; each constraint of the System becomes a bar, or gives its
/// distance to the bar that is on its pair already.
/// @param framework  of as many joints as the System has particles
/// @throw OpenMMException if a constraint, bar, tether, contact, volume or contact radius is on a
///        virtual site: its position follows from other particles and cannot be resolved
std::shared_ptr<const Framework> frameworkOf(const Framework& framework,
                                             const OpenMM::System& system);

}  // namespace ragdoll
