"""The version of the package; CMakeLists.txt states it."""

from importlib.metadata import version

__version__ = version("openmm-ragdoll")
