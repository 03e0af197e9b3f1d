"""From a molecule and its framework to an OpenMM System without a force field."""

import openmm

from ._core import Framework
from .integrator import FrameworkForce
from .molecule import Molecule


def make_system(molecule: Molecule, framework: Framework) -> openmm.System:
    """A System with the molecule's masses and the framework's molecules, and no other force.

    A box of the molecule makes it periodic: contacts are then by minimum image.

    Args:
        molecule: gives the masses and the box.
        framework: what FrameworkForce shows to OpenMM as bonded.
    """
    system = openmm.System()
    for mass in molecule.masses:
        system.addParticle(float(mass))
    force = FrameworkForce(framework)
    if molecule.box_vectors is not None:
        system.setDefaultPeriodicBoxVectors(*(openmm.Vec3(*row) for row in molecule.box_vectors))
        force.setUsesPeriodicBoundaryConditions(True)
    system.addForce(force)
    return system
