"""Ragdoll physics for molecules: geometric simulation as an OpenMM plugin.

The flow: a molecule becomes a framework of joints and bars; each step breaks it and resolves it;
the frames go to a trajectory. Lengths are nm, times ps, masses dalton, energies kJ/mol, as in
OpenMM.
"""

from ._core import Framework
from .errors import InputError
from .framework import build_framework
from .integrator import FrameworkForce, RagdollIntegrator
from .method.classifying import classify
from .method.experiment import experiment
from .method.generating import generate
from .method.ordering import order
from .method.resolving import resolve
from .molecule import Molecule
from .reporter import TrajectoryReporter
from .sampling import SampleOptions, SampleReport, sample
from .system import make_system
from .trajectory import Trajectory, TrajectoryError, open_trajectory
from .version import __version__

__all__ = [
    "Framework",
    "FrameworkForce",
    "InputError",
    "Molecule",
    "RagdollIntegrator",
    "SampleOptions",
    "SampleReport",
    "Trajectory",
    "TrajectoryError",
    "TrajectoryReporter",
    "__version__",
    "build_framework",
    "classify",
    "experiment",
    "generate",
    "make_system",
    "open_trajectory",
    "order",
    "resolve",
    "sample",
]
