"""A step of adenylate kinase: RagdollIntegrator, and OpenMM's molecular dynamics beside it."""

import statistics
import time
from pathlib import Path

import openmm
from openmm import app, unit

import ragdoll
from molecules import find
from programs import Records

KINASE = "4ake_a_withH.pdb"


def cpu_context(system: openmm.System, integrator: openmm.Integrator, positions):
    """A Context on the CPU platform with one thread."""
    platform = openmm.Platform.getPlatformByName("CPU")
    context = openmm.Context(system, integrator, platform, {"Threads": "1"})
    context.setPositions(positions)
    return context


def ragdoll_context(molecule: ragdoll.Molecule) -> openmm.Context:
    """Gaussian steps of 0.02 A per coordinate, tolerance 0.01, contacts on."""
    framework = ragdoll.build_framework(molecule, contacts=True)
    integrator = ragdoll.RagdollIntegrator(
        framework=framework,
        tolerance=0.01,
        perturbation="gaussian",
        perturbationSize=0.02 * unit.angstrom,
        rejectUnresolved=True,
    )
    return cpu_context(
        ragdoll.make_system(molecule, framework), integrator, molecule.positions * unit.nanometer
    )


def md_context(file: Path) -> openmm.Context:
    """amber14 in vacuum, minimised, at 300 K: Verlet, 2 fs, HBonds, cutoff 1.2 nm without a box."""
    field = app.ForceField("amber14-all.xml")
    pdb = app.PDBFile(str(file))
    model = app.Modeller(pdb.topology, pdb.positions)
    options = {
        "nonbondedMethod": app.CutoffNonPeriodic,
        "nonbondedCutoff": 1.2 * unit.nanometer,
        "constraints": app.HBonds,
    }
    try:
        system = field.createSystem(model.topology, **options)
    except ValueError:
        # amber14 has no templates for the file's hydrogens: they are placed anew
        hydrogen = app.element.hydrogen
        model.delete([atom for atom in model.topology.atoms() if atom.element is hydrogen])
        model.addHydrogens(field, platform=openmm.Platform.getPlatformByName("CPU"))
        system = field.createSystem(model.topology, **options)
    context = cpu_context(system, openmm.VerletIntegrator(2 * unit.femtosecond), model.positions)
    openmm.LocalEnergyMinimizer.minimize(context, maxIterations=200)
    context.setVelocitiesToTemperature(300 * unit.kelvin, 1)
    return context


def seconds_of(context: openmm.Context, steps: int) -> float:
    start = time.perf_counter()
    context.getIntegrator().step(steps)
    return time.perf_counter() - start


def accepted_step(context: openmm.Context, integrator, attempts: int) -> float:
    """Seconds for one accepted step: those of the rejected ones are in it."""
    rejected = integrator.getRejectedSteps()
    seconds = seconds_of(context, attempts)
    return seconds / max(1, attempts - (integrator.getRejectedSteps() - rejected))


def records() -> Records:
    """Medians over blocks of steps, ours and MD's in turn; nothing where the file is not there."""
    file = find(KINASE)
    if file is None:
        return []
    ours = ragdoll_context(ragdoll.Molecule.from_file(file))
    integrator = ragdoll.RagdollIntegrator.cast(ours.getIntegrator())
    md = md_context(file)
    accepted_step(ours, integrator, 20)  # warm up: orders, pair lists
    seconds_of(md, 20)
    times = [(accepted_step(ours, integrator, 100), seconds_of(md, 20) / 20) for _ in range(15)]
    return [
        {"what": "step", "molecule": "adenylate kinase", "contender": contender, "ms": 1e3 * median}
        for contender, median in zip(
            ("RagdollIntegrator", "MD, amber14 in vacuum"),
            (statistics.median(side) for side in zip(*times, strict=True)),
            strict=True,
        )
    ]
