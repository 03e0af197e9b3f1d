"""Ragdoll physics for molecules: geometric simulation as an OpenMM plugin.

The flow: a molecule becomes a framework of joints and bars; each step breaks it and resolves it; the
frames go to a trajectory. Lengths are nm, times ps, masses dalton, energies kJ/mol, as in OpenMM.
"""

from importlib.metadata import version as _version

from . import _core
from ._core import Framework
from .errors import InputError
from .framework import build_framework
from .integrator import FrameworkForce, RagdollIntegrator
from .molecule import Molecule
from .sampling import SampleReport, sample
from .system import make_system
from .trajectory import Trajectory, TrajectoryError, open_trajectory

__version__ = _version("openmm-ragdoll")

__all__ = [
    "Framework",
    "FrameworkForce",
    "InputError",
    "Molecule",
    "RagdollIntegrator",
    "SampleReport",
    "Trajectory",
    "TrajectoryError",
    "TrajectoryReporter",
    "build_framework",
    "make_system",
    "open_trajectory",
    "sample",
]


from .reporter import TrajectoryReporter  # noqa: E402  (it asks for __version__)
