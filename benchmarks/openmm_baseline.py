"""The baseline O: what OpenMM's Context takes to be made with constraints, and applyConstraints.

On the Reference platform: CCMA in doubles, on one core. The CPU platform runs the same code.
"""

import time

import numpy as np
import openmm
from openmm import unit

from molecules import HeavyAtoms

Records = list[dict]


def angles_of(bonds: np.ndarray, atoms: int) -> list[tuple[int, int, int]]:
    """Atoms a-b-c for every two bonds that share b."""
    around: list[list[int]] = [[] for _ in range(atoms)]
    for a, b in bonds:
        around[a].append(int(b))
        around[b].append(int(a))
    return [
        (near[i], centre, near[j])
        for centre, near in enumerate(around)
        for i in range(len(near))
        for j in range(i + 1, len(near))
    ]


def constrained_system(molecule: HeavyAtoms, *, angle_forces: bool, angle_bars: bool = False):
    """The molecule's bonds as constraints, its 1-3 distances too if asked for.

    Angle forces tell CCMA how constraints are coupled, as they do in every force field.
    """
    system = openmm.System()
    for mass in molecule.masses:
        system.addParticle(float(mass))
    x = molecule.positions
    angles = angles_of(molecule.bonds, len(x)) if angle_forces or angle_bars else []
    pairs = {tuple(sorted(map(int, pair))) for pair in molecule.bonds}
    if angle_bars:
        pairs |= {tuple(sorted((a, c))) for a, _, c in angles}
    for a, b in sorted(pairs):
        system.addConstraint(a, b, float(np.linalg.norm(x[b] - x[a])))
    if angle_forces:
        force = openmm.HarmonicAngleForce()
        for a, b, c in angles:
            u, v = x[a] - x[b], x[c] - x[b]
            cosine = u @ v / (np.linalg.norm(u) * np.linalg.norm(v))
            force.addAngle(a, b, c, float(np.arccos(np.clip(cosine, -1, 1))), 400.0)
        system.addForce(force)
    return system


def made_context(system: openmm.System) -> tuple[openmm.Context, float]:
    """A Context, and the seconds that it took."""
    integrator = openmm.VerletIntegrator(0.001)
    integrator.setConstraintTolerance(1e-5)
    platform = openmm.Platform.getPlatformByName("Reference")
    start, work = time.perf_counter(), time.process_time()
    context = openmm.Context(system, integrator, platform)
    # without the time in which the machine gave the core to others
    seconds = min(time.perf_counter() - start, time.process_time() - work)
    # the context keeps a C++ pointer: Python must keep the integrator
    context.integrator_kept = integrator
    return context, seconds


def worst_relative(system: openmm.System, x: np.ndarray) -> float:
    """Largest |d - L| / L of the constraints; infinity where there is no number."""
    constraints = [system.getConstraintParameters(k) for k in range(system.getNumConstraints())]
    a, b = np.array([c[:2] for c in constraints]).T
    lengths = np.array([c[2].value_in_unit(unit.nanometer) for c in constraints])
    with np.errstate(all="ignore"):
        worst = float(np.max(np.abs(np.linalg.norm(x[b] - x[a], axis=1) - lengths) / lengths))
    return worst if np.isfinite(worst) else float("inf")


class Applied:
    """applyConstraints on one network, "bonds" or "bonds and 1-3"; keeps the best times."""

    def __init__(self, network: str, molecule: HeavyAtoms, *, angle_forces: bool) -> None:
        self.network, self.molecule, self.angle_forces = network, molecule, angle_forces
        self.system = constrained_system(
            molecule, angle_forces=angle_forces, angle_bars=network == "bonds and 1-3"
        )
        self.context, _ = made_context(self.system)
        self.best: dict[tuple[float, float], list[float]] = {}
        self.worst: dict[tuple[float, float], float] = {}

    def measure(self, sigma: float, tolerance: float, breaks: int) -> None:
        """sigma: nm for each coordinate."""
        key = (sigma, tolerance)
        best = self.best.setdefault(key, [float("inf")] * breaks)
        for k in range(breaks):
            noise = np.random.default_rng(k).standard_normal(self.molecule.positions.shape)
            x = self.molecule.positions + sigma * noise
            self.context.setPositions(x)
            start = time.perf_counter()
            self.context.applyConstraints(tolerance)
            best[k] = min(best[k], time.perf_counter() - start)
            state = self.context.getState(positions=True)
            moved = state.getPositions(asNumpy=True).value_in_unit(unit.nanometer)
            worst = worst_relative(self.system, moved)
            self.worst[key] = max(self.worst.get(key, 0.0), worst)

    def records(self) -> Records:
        return [
            {
                "what": "openmm",
                "network": self.network,
                "molecule": self.molecule.name,
                "joints": len(self.molecule.masses),
                "bars": self.system.getNumConstraints(),
                "angle_forces": self.angle_forces,
                "sigma_angstrom": 10 * sigma,
                "tolerance": tolerance,
                "ms": 1e3 * float(np.mean(best)),
                # CCMA tells nobody whether it converged
                "worst_relative": None if np.isinf(worst) else worst,
                "converged": bool(worst <= tolerance * 1.01),
            }
            for (sigma, tolerance), best in self.best.items()
            for worst in (self.worst[sigma, tolerance],)
        ]


def setup_record(molecule: HeavyAtoms) -> dict:
    """Making a Context whose constraints are the molecule's bonds, with the angle forces of every
    force field.
    """
    _, seconds = made_context(constrained_system(molecule, angle_forces=True))
    return {
        "what": "setup",
        "network": "bonds",
        "part": "openmm",
        "joints": len(molecule.masses),
        "ms": 1e3 * seconds,
    }
