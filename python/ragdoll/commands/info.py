"""``ragdoll info``: versions, platforms, plugin libraries, and a step on each platform of ours."""

import json
import platform as machine
from importlib.metadata import PackageNotFoundError, version
from typing import Annotated, Any

import numpy as np
import openmm
import typer
from rich.console import Console

from .. import plugin
from ..exits import DONE, FAILED
from ..version import __version__

_KERNELS = ["IntegrateRagdollStep"]


def run(
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> int:
    """Print versions, platforms, plugin libraries, and try one step on each platform of ours."""
    facts = gather()
    if as_json:
        typer.echo(json.dumps(facts, indent=2))
    else:
        _print(Console(highlight=False, markup=False, soft_wrap=True), facts)
    failed = [entry for entry in facts["platforms"] if entry["kernels"] and not entry["step"]]
    return FAILED if failed else DONE


def gather() -> dict[str, Any]:
    """What the command prints, as plain values."""
    packages = ("openmm", "numpy", "rdkit", "gemmi", "pdbfixer", "mdtraj", "MDAnalysis")
    return {
        "version": __version__,
        "python": machine.python_version(),
        "packages": {name: _version(name) for name in packages},
        "openmm_libraries": list(openmm.pluginLoadedLibNames),
        "ragdoll_libraries": plugin.loaded_libraries(),
        "load_failures": list(openmm.Platform.getPluginLoadFailures()) + plugin.load_failures(),
        "platforms": [_platform(index) for index in range(openmm.Platform.getNumPlatforms())],
    }


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _platform(index: int) -> dict[str, Any]:
    platform = openmm.Platform.getPlatform(index)
    entry = {"name": platform.getName(), "kernels": bool(platform.supportsKernels(_KERNELS))}
    entry["step"], entry["error"] = False, ""
    if entry["kernels"]:
        try:
            entry["step"] = _step(platform)
        except openmm.OpenMMException as error:
            entry["error"] = str(error)
    return entry


def _step(platform: openmm.Platform) -> bool:
    """Stretch a bar between two joints and see whether a step resolves it."""
    from .. import Framework, RagdollIntegrator

    framework = Framework(
        masses=np.ones(2), bars=np.array([[0, 1]], dtype=np.int32), bar_lengths=np.ones(1)
    )
    system = openmm.System()
    system.addParticle(1.0)
    system.addParticle(1.0)
    integrator = RagdollIntegrator(framework=framework)
    context = openmm.Context(system, integrator, platform)
    context.setPositions([[0.0, 0.0, 0.0], [1.5, 0.0, 0.0]])
    integrator.step(1)
    x = context.getState(positions=True).getPositions(asNumpy=True)._value
    return bool(integrator.getConverged() and abs(np.linalg.norm(x[1] - x[0]) - 1) < 1e-3)


def _print(console: Console, facts: dict[str, Any]) -> None:
    console.print(f"ragdoll {facts['version']}, Python {facts['python']}")
    for name, number in facts["packages"].items():
        console.print(f"  {name} {number or 'is not installed'}")
    console.print("libraries that OpenMM loaded:")
    for library in facts["openmm_libraries"] + facts["ragdoll_libraries"]:
        console.print(f"  {library}")
    console.print("libraries that did not load: " + ("" if facts["load_failures"] else "none"))
    for failure in facts["load_failures"]:
        console.print(f"  {failure}")
    console.print("platforms:")
    for entry in facts["platforms"]:
        if not entry["kernels"]:
            words = "has no kernels of ragdoll"
        elif entry["step"]:
            words = "took a step of RagdollIntegrator"
        else:
            words = f"FAILED to take a step {entry['error']}"
        console.print(f"  {entry['name']}: {words}")
