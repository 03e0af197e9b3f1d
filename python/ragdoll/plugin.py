"""Loads ragdoll's OpenMM plugin: its API library, then a library for each platform.

The API library comes with the binding ``_openmm``; platform libraries lie in the folder ``lib``.
"""

import warnings
from pathlib import Path
from types import ModuleType

import openmm

_VERSION = "8.6"
_FOLDER = Path(__file__).parent / "lib"
_PREFIX = "libOpenMMRagdoll"

_loaded: list[str] = []
_failures: list[str] = []


def loaded_libraries() -> list[str]:
    """Paths of the platform libraries that were loaded, as text."""
    return list(_loaded)


def load_failures() -> list[str]:
    """A sentence for each platform library that is installed but was not loaded."""
    return list(_failures)


def _require_openmm_version() -> None:
    version = openmm.Platform.getOpenMMVersion()
    if version.split(".")[:2] != _VERSION.split("."):
        raise ImportError(
            f"This ragdoll was built for OpenMM {_VERSION}, but OpenMM {version} is installed."
        )


def _platform_names() -> set[str]:
    count = openmm.Platform.getNumPlatforms()
    return {openmm.Platform.getPlatform(index).getName() for index in range(count)}


def _load_platform_library(library: Path) -> None:
    """Loads one library. What is broken is said aloud; what has no platform here is only noted."""
    platform = library.stem.removeprefix(_PREFIX)
    if platform not in _platform_names():
        _failures.append(f"{library.name}: OpenMM has no {platform} platform here.")
        return
    try:
        openmm.Platform.loadPluginLibrary(str(library))
    except openmm.OpenMMException as error:
        _failures.append(f"{library.name}: {error}")
        warnings.warn(f"RagdollIntegrator cannot use {platform}: {error}", stacklevel=2)
    else:
        _loaded.append(str(library))


def load() -> ModuleType:
    """Loads the plugin; a second call loads nothing.

    Returns
    -------
    module
        ``_openmm``, which reaches the C++ objects behind OpenMM's Python objects

    Raises
    ------
    ImportError
        if OpenMM has another version, or the library of the Reference platform does not load
    """
    _require_openmm_version()
    # the API library has to be there before the platform libraries, which need it
    from ragdoll import _openmm

    if _loaded:
        return _openmm
    _failures.clear()
    for library in sorted(_FOLDER.glob(f"{_PREFIX}?*.so")):
        _load_platform_library(library)
    if not any(Path(path).stem == f"{_PREFIX}Reference" for path in _loaded):
        reasons = " ".join(_failures) or f"There is no {_PREFIX}Reference.so in {_FOLDER}."
        raise ImportError(f"RagdollIntegrator cannot be used. {reasons}")
    return _openmm
