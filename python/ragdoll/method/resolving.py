"""Forces on one structure, resolved by one technique."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from .. import _core
from ..errors import InputError
from .ordering import order as order_of
from .sources import ForceSet, Structure, force_sizes, forces_of, refusals, structure_of
from .statistics import Statistics, counted_iterations, statistics_of
from .technique import check_technique


@dataclass(frozen=True, eq=False, repr=False)
class Resolution:
    """What became of each force; F forces, N joints.

    Attributes:
        order, weighting, solver, verlet: the technique.
        iterations: (F,) int64 passes over the order.
        bar_visits: (F,) int64 bars visited in them.
        converged: (F,) bool.
        residual: (F,) largest relative violation of a constraint afterwards.
        carried: (F,) int64 cycle blocks that no deformation resolved (planar and mirror traps), so
            that ``block`` carried them whole, in the shape they had.
        residual_angstrom: (F,) largest violation as a length; None if the structure's unit of
            length is not known.
        solver_chosen: the solver that worked: with ``auto``, its choice.
        reasons: why each ended.
        joints: (F,) int32 the forced joints; ``ids`` names the structure's joints.
        sizes: (F,) |F|/m dt^2 in mean bar lengths.
        positions: (N, 3) after the last force, in the structure's unit.
        frames: (F, N, 3) after each force, or None if they were not asked for.
        max_iterations, tolerance, tolerance_angstrom, precision, timestep: what held; one of the
            tolerances is None.
    """

    order: str
    weighting: str
    solver: str
    verlet: str
    seed: int
    max_iterations: int
    tolerance: float | None
    timestep: float
    iterations: np.ndarray
    bar_visits: np.ndarray
    converged: np.ndarray
    residual: np.ndarray
    reasons: list[str]
    joints: np.ndarray
    sizes: np.ndarray
    positions: np.ndarray
    frames: np.ndarray | None
    ids: list[str] = field(default_factory=list)
    tolerance_angstrom: float | None = None
    precision: str = "double"
    solver_chosen: str = ""
    residual_angstrom: np.ndarray | None = None
    carried: np.ndarray | None = None

    def __len__(self) -> int:
        """Return the number of forces."""
        return len(self.iterations)

    def __repr__(self) -> str:
        """Return one line; the arrays would fill pages."""
        failed = int(np.count_nonzero(~self.converged))
        return f"<Resolution by {self.order} {self.weighting}: {len(self)} forces, {failed} failed>"

    def statistics(self) -> Statistics:
        """Mean, mode, deviation and percentiles of the iterations."""
        counted = counted_iterations(self.iterations, self.converged, self.max_iterations)
        return statistics_of(counted, self.converged, self.bar_visits)

    def records(self) -> list[dict[str, Any]]:
        """A record for each force; ``pandas.DataFrame(r.records())`` is a table."""
        return [
            {
                "force": k + 1,
                "joint": self.ids[self.joints[k]],
                "size": float(self.sizes[k]),
                "order": self.order,
                "weighting": self.weighting,
                "solver": self.solver,
                "iterations": int(self.iterations[k]),
                "bar_visits": int(self.bar_visits[k]),
                "converged": bool(self.converged[k]),
                "residual": float(self.residual[k]),
                "reason": self.reasons[k],
            }
            for k in range(len(self))
        ]

    def as_dict(self) -> dict[str, Any]:
        """The object that ``ragdoll resolve --json`` prints; a residual that is no number: None."""
        return {
            "order": self.order,
            "weighting": self.weighting,
            "solver": self.solver,
            "verlet": self.verlet,
            "solver_chosen": self.solver_chosen,
            "precision": self.precision,
            "tolerance": self.tolerance,
            "tolerance_angstrom": self.tolerance_angstrom,
            "max_iterations": self.max_iterations,
            "iterations": self.iterations.tolist(),
            "bar_visits": self.bar_visits.tolist(),
            "converged": self.converged.tolist(),
            "carried": [] if self.carried is None else self.carried.tolist(),
            "residual": _numbers(self.residual),
            "residual_angstrom": _numbers(self.residual_angstrom),
            "reason": self.reasons,
            **self.statistics().as_dict(),
        }


#: units of length that a structure may name, per angstrom
_UNITS = {"none": 0.1, "nm": 0.1, "angstrom": 1.0, "a": 1.0, "å": 1.0, "pm": 100.0}


def units_per_angstrom(structure: Structure) -> float | None:
    """An angstrom in the structure's unit of length; None if that unit is not known.

    A structure without a unit, ``none``, counts in nm.
    """
    return _UNITS.get((structure.length_unit or "none").lower())


def _absolute_tolerance(structure, tolerance, tolerance_angstrom) -> float | None:
    """``tolerance_angstrom`` in the structure's unit."""
    if tolerance_angstrom is None:
        return None
    if tolerance is not None:
        raise InputError("--tolerance and --tolerance-angstrom exclude each other; give one.")
    angstrom = units_per_angstrom(structure)
    if angstrom is None:
        raise InputError(
            f"--tolerance-angstrom needs a structure in nm or angstrom, not in "
            f"{structure.length_unit}; give --tolerance."
        )
    return tolerance_angstrom * angstrom


def _numbers(values: np.ndarray | None) -> list[float | None] | None:
    """As JSON has them: what is no number is None."""
    if values is None:
        return None
    return [value if np.isfinite(value) else None for value in values.tolist()]


def resolve(
    structure: Structure | str | Path,
    forces: ForceSet | str | Path | Sequence[tuple[Any, Sequence[float]]],
    order: str = "bfs_cycle",
    weighting: str = ".5/.5",
    *,
    solver: str = "ordered",
    verlet: str = "affected",
    seed: int = 0,
    frames: bool = False,
    max_iterations: int | None = None,
    tolerance: float | None = None,
    tolerance_angstrom: float | None = None,
    precision: str = "double",
    progress: Callable[[int, int], None] | None = None,
) -> Resolution:
    """Break a structure by each force in turn, and resolve it.

    Args:
        structure: a structure, or its file.
        forces: a force set, its file, or (joint, (x, y, z)) pairs.
        order: a name, or ``file:PATH`` of an order file.
        weighting: the far end's share first.
        solver: ``ordered``, another that core has, or ``auto``.
        verlet: ``affected``: forced joints move; ``all``: every joint with its velocity.
        seed: of random orders.
        frames: keep the positions after each force.
        max_iterations, tolerance: in the place of the force set's.
        tolerance_angstrom: in the place of the relative tolerance, largest |d - L| of any
            constraint; a unit of a structure without a unit of length is 1 nm.
        precision: of the solver's numbers, ``double`` or ``single``.
        progress: called with the forces done and all forces.

    Raises:
        InputError: something does not fit; the message says what.
    """
    structure = structure_of(structure)
    force_set = forces_of(forces, structure)
    custom, custom_problem = None, None
    if order.startswith("file:"):
        bar_order = order_of(structure, order)
        custom, custom_problem = bar_order.bars, bar_order.closes_cycle.astype(np.uint8)
    named = "bfs_cycle" if custom is not None else order
    technique = check_technique(named, weighting, solver)
    absolute = _absolute_tolerance(structure, tolerance, tolerance_angstrom)
    if verlet not in ("affected", "all"):
        raise InputError(f"--verlet '{verlet}' is not known; choose affected or all.")
    with refusals():
        done = _core.resolve_forces(
            structure,
            force_set,
            technique.order,
            technique.weighting,
            solver,
            verlet,
            seed,
            custom_order=custom,
            custom_problem=custom_problem,
            frames=frames,
            max_iterations=max_iterations,
            tolerance=tolerance,
            absolute_tolerance=absolute,
            precision=precision,
            progress=None if progress is None else lambda n: progress(n, len(force_set)),
        )
    relative = force_set.tolerance if tolerance is None else tolerance
    angstrom = units_per_angstrom(structure)
    return Resolution(
        order=order,
        weighting=technique.weighting,
        solver=solver,
        verlet=verlet,
        seed=seed,
        max_iterations=force_set.max_iterations if max_iterations is None else max_iterations,
        tolerance=relative if tolerance_angstrom is None else None,
        tolerance_angstrom=tolerance_angstrom,
        precision=precision,
        solver_chosen=done["solver"],
        timestep=force_set.timestep,
        iterations=np.asarray(done["iterations"], dtype=np.int64),
        bar_visits=np.asarray(done["bar_visits"], dtype=np.int64),
        converged=np.asarray(done["converged"], dtype=bool),
        carried=np.asarray(done["carried"], dtype=np.int64),
        residual=np.asarray(done["residual"], dtype=np.float64),
        residual_angstrom=None if angstrom is None else np.asarray(done["residual_nm"]) / angstrom,
        reasons=list(done["reasons"]),
        joints=np.asarray(force_set.joints),
        sizes=force_sizes(structure, force_set),
        positions=np.asarray(done["positions"]),
        frames=np.asarray(done["frames"]) if frames else None,
        ids=list(structure.ids),
    )
