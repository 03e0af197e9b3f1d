"""What is measured: each part returns records, made by the C++ program or by OpenMM."""

import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import openmm_baseline
import programs
import steps
from molecules import HeavyAtoms, heavy_atoms, load, read, villin
from programs import Records

Say = Callable[[str], None]


@dataclass(frozen=True)
class Plan:
    """How much of everything: enough for rough numbers, or for good ones."""

    forces: int  # of block, over all classes
    repetitions: int  # of small cycles, of bar visits
    numbering: tuple[int, ...]  # joints
    forced: tuple[int, ...]  # joints
    proteins: int
    breaks: int  # of a protein, one after the other
    seconds: float  # for each solver and baseline on a protein, before it is repeated no more
    rounds: int  # ours and OpenMM's in turn
    conformers: float  # seconds, for each solver and precision
    sizes: tuple[int, ...]  # joints
    largest_for_sweeps: int
    setup: tuple[int, ...]  # joints
    setup_openmm: tuple[int, ...]
    steps: bool  # of the integrator, beside molecular dynamics


QUICK = Plan(
    forces=120_000,
    repetitions=20,
    numbering=(100_000,),
    forced=(100, 1_000, 10_000, 100_000, 1_000_000),
    proteins=2,
    breaks=4,
    seconds=0.3,
    rounds=2,
    conformers=2,
    sizes=(100, 1_000, 10_000, 100_000, 1_000_000),
    largest_for_sweeps=100_000,
    setup=(3_000, 30_000, 300_000),
    setup_openmm=(3_000, 30_000),
    steps=False,
)
FULL = Plan(
    forces=1_200_000,
    repetitions=200,
    numbering=(100_000, 1_000_000),
    forced=(100, 1_000, 10_000, 100_000, 1_000_000, 10_000_000),
    proteins=3,
    breaks=20,
    seconds=3,
    rounds=5,
    conformers=10,
    sizes=(100, 300, 1_000, 3_000, 10_000, 30_000, 100_000, 300_000, 1_000_000),
    largest_for_sweeps=1_000_000,
    setup=(3_000, 30_000, 300_000, 3_000_000, 10_000_000),
    setup_openmm=(3_000, 10_000, 30_000),
    steps=True,
)


def named(records: Records, molecule: HeavyAtoms) -> Records:
    return [record | {"molecule": molecule.name} for record in records]


def proteins(plan: Plan, folder: Path) -> Records:
    """All joints displaced, everything but contacts."""
    records = []
    for molecule in load(plan.proteins):
        file = folder / f"{molecule.name}.txt"
        molecule.write(file)
        records += named(programs.run("molecule", file, plan.breaks, plan.seconds), molecule)
    return records


def bonds(plan: Plan, folder: Path) -> Records:
    """Bonds alone, ours and OpenMM's in turn; and where OpenMM's fails."""
    molecule = load(1)[0]
    file = folder / f"{molecule.name}.txt"
    molecule.write(file)
    rivals = [
        openmm_baseline.Applied("bonds", molecule, angle_forces=angles) for angles in (True, False)
    ]
    best: dict[tuple, dict] = {}
    for _ in range(plan.rounds):
        for record in programs.run("bonds", file, plan.breaks, plan.seconds / plan.rounds):
            key = (record["tolerance"], record["contender"])
            if key not in best or record["ms"] < best[key]["ms"]:
                best[key] = record
        for rival in rivals:
            for tolerance in (6e-4, 1e-6):
                rival.measure(0.01, tolerance, plan.breaks)
    beside: Records = []  # ours where OpenMM's fails
    for sigma in (0.02, 0.03):
        beside += where_openmm_fails(molecule, "bonds", sigma, folder)
        for rival in rivals:
            rival.measure(sigma, 6e-4, plan.breaks)
    small = heavy_atoms("villin", villin())
    angles = openmm_baseline.Applied("bonds and 1-3", small, angle_forces=True)
    angles.measure(0.001, 6e-4, 2)
    beside += where_openmm_fails(small, "bonds and 1-3", 0.001, folder)
    records = named(list(best.values()), molecule) + beside
    for rival in (*rivals, angles):
        records += rival.records()
    return records


def where_openmm_fails(molecule: HeavyAtoms, network: str, sigma: float, folder: Path) -> Records:
    """Our solvers' records, kept apart from those of the rows."""
    file = folder / f"{molecule.name}.txt"
    molecule.write(file)
    found = named(programs.run("fails", file, network, sigma), molecule)
    return [record | {"what": "fails", "sigma_angstrom": 10 * sigma} for record in found]


def conformers(plan: Plan, folder: Path) -> Records:
    molecule = load(1)[0]
    file = folder / f"{molecule.name}.txt"
    molecule.write(file)
    return named(programs.run("conformers", file, plan.conformers), molecule)


def sizes(plan: Plan, folder: Path) -> Records:
    """A peptide, longer and longer; OpenMM's on its bonds up to 10,000 joints."""
    records = programs.run("sizes", plan.largest_for_sweeps, *plan.sizes)
    for joints in (size for size in plan.sizes if size <= 10_000):
        rival = openmm_baseline.Applied("bonds", peptide(joints, folder), angle_forces=False)
        rival.measure(0.01, 6e-4, 5)
        records += rival.records()
    return records


def setup(plan: Plan, folder: Path) -> Records:
    records = programs.run("setup", *plan.setup)
    for joints in plan.setup_openmm:
        records.append(openmm_baseline.setup_record(peptide(joints, folder)))
    return records


def peptide(joints: int, folder: Path) -> HeavyAtoms:
    """The peptide that the C++ program makes."""
    file = folder / f"peptide{joints}.txt"
    programs.run("peptide", joints, file)
    return read("peptide", file)


def everything(plan: Plan, say: Say) -> Records:
    """All parts; `say` is told what comes next."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        parts: list[tuple[str, Callable[[], Records]]] = [
            ("bar visits", lambda: programs.run("visits", plan.repetitions)),
            ("joints numbered anyhow", lambda: programs.run("numbering", *plan.numbering)),
            ("small cycles", lambda: programs.run("cycles", plan.forces, plan.repetitions)),
            ("one forced joint", lambda: programs.run("forced", *plan.forced)),
            ("proteins", lambda: proteins(plan, folder)),
            ("bonds, beside OpenMM", lambda: bonds(plan, folder)),
            ("accepted conformers", lambda: conformers(plan, folder)),
            ("sizes", lambda: sizes(plan, folder)),
            ("set-up, beside OpenMM's", lambda: setup(plan, folder)),
        ]
        if plan.steps:
            parts.append(("steps, beside molecular dynamics", steps.records))
        records: Records = []
        for title, part in parts:
            say(f"{title} ...")
            records += part()
        return records
