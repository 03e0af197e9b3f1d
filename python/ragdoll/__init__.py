"""Ragdoll physics for molecules: geometric simulation as an OpenMM plugin.

The flow: a molecule becomes a framework of joints and bars; each step breaks it and resolves it;
the frames go to a trajectory. Lengths are nm, times ps, masses dalton, energies kJ/mol, as in
OpenMM.
"""

import sys
from importlib import import_module

# where each public name lives; it is imported when it is first asked for, so that the command line
# answers at once, also to Ctrl-C
_HOMES = {
    "BatchReport": "batch.report",
    "ConformerOptions": "batch.conforming",
    "ConstraintOptions": "constraint_options",
    "DilutionResult": "rigidity_analysis",
    "EnsembleResolver": "_core",
    "Framework": "_core",
    "FrameworkForce": "integrator",
    "InputError": "errors",
    "Modes": "elastic_network",
    "Molecule": "molecule",
    "MotionOptions": "motion_options",
    "PrepareOptions": "prepare_report",
    "PrepareReport": "prepare_report",
    "QualityLimits": "quality_limits",
    "QualityReport": "quality_report",
    "RagdollIntegrator": "integrator",
    "RigidityOptions": "bond_lists",
    "RigidityResult": "rigidity_analysis",
    "SampleOptions": "sampling",
    "SampleReport": "sampling",
    "TargetOptions": "targeting",
    "TargetReport": "targeting",
    "Trajectory": "trajectory",
    "TrajectoryError": "trajectory",
    "TrajectoryReporter": "reporter",
    "UserConstraint": "user_constraints",
    "__version__": "version",
    "build_framework": "framework",
    "classify": "method.classifying",
    "conformers": "batch.conforming",
    "conformers_of_file": "batch.run",
    "dilution": "rigidity_analysis",
    "experiment": "method.experiment",
    "generate": "method.generating",
    "make_system": "system",
    "modes": "elastic_network",
    "molecule_names": "trajectory",
    "network_rigidity": "rigidity_analysis",
    "open_trajectory": "trajectory",
    "order": "method.ordering",
    "prepare": "preparing",
    "quality": "quality_report",
    "resolve": "method.resolving",
    "rigidity": "rigidity_analysis",
    "sample": "sampling",
    "target": "targeting",
}

__all__ = sorted(_HOMES)


def __getattr__(name: str):
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f".{_HOMES[name]}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOMES})


# who has OpenMM at hand may go on to its XmlSerializer, which has to know our classes
if "openmm" in sys.modules:
    from . import plugin  # noqa: F401
