// Ring frame: the framework of some atoms of a molecule, the rest left out. Private to core.

#pragma once
#include <span>
#include <vector>

#include "pliant_rings.h"       // PliantRings
#include "ragdoll/framework.h"  // FrameworkParts

namespace ragdoll {

/// The parts of a framework that hold these joints alone, in this order; what reaches beyond them
/// is left out. All joints weigh the same.
FrameworkParts restricted(const FrameworkParts& parts, std::span<const int> joints);

/// Volumes of ring atoms from which three bonds go to the ring system and one beside it, by the
/// centre and those three: without the fourth, nothing else keeps their hand. Indices are those of
/// `atoms`, which are ascending.
void add_ring_centres(const Molecule& molecule, const PliantRings& pliant,
                      std::span<const int> atoms, FrameworkParts& parts);

/// Writes out the pairs of a contact rule as contacts, where joints are few: none of them has to be
/// searched for.
void write_out_contacts(FrameworkParts& parts);

}  // namespace ragdoll
