"""Targeted motion: a path from one structure to another, every frame within its constraints."""

import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from . import _core
from .backbone_guide import make_guide, outlier_atoms, torsions_of
from .errors import InputError
from .framework import build_framework, framework_arrays, peptide_torsions
from .matching import Match, match, placed, rigid_move
from .molecule import Molecule
from .quality_report import quality
from .residue_match import residue_label
from .rounding import rounding_of
from .sample_report import geometry_dict
from .sites import site_of
from .target_options import TargetOptions
from .trajectory import Trajectory, TrajectoryWriter, check_output
from .user_constraints import fixed_atoms
from .version import __version__

__all__ = ["TargetOptions", "TargetReport", "target"]

_ANGSTROM = 10.0  # per nm
_STEP_SIZE = 0.001  # ps; what a step counts as in the file
_WIDEST = 0.5  # angstrom; no CA goes further from one frame to the next
_CLOSE = 0.05  # angstrom; CA RMSD of structures that are one
_CARRIED = 0.01  # weight of ligands where backbones or CA alone are drawn, and of those without end
_OBSERVABLES = {
    "iterations": int,
    "bar_visits": int,
    "residual": float,
    "converged": int,
    "rmsd": float,
    "target_rmsd": float,
}


@dataclass
class TargetReport:
    """What came of a path; as_dict() is the object that ``ragdoll target --json`` prints.

    RMSDs are of CA atoms (P of nucleotides) after superposition; ``all_rmsd_end_angstrom`` is of
    all atoms that have a target. Where atoms are fixed the target is laid over these, RMSDs are
    without superposition, and of the CA atoms that can move (of other atoms where none can).
    ``constraints`` counts what both ends have, by kind; of planar units and the like,
    ``bounds_widened`` were widened for the end and ``bounds_dropped`` left out. ``quality`` is
    measured on the written frames.
    ``widest_step_angstrom`` is the most that a CA moves from one frame to the next.
    """

    frames: int = 0
    rmsd_start_angstrom: float = 0.0
    rmsd_end_angstrom: float = 0.0
    all_rmsd_end_angstrom: float = 0.0
    arrived: bool = False
    cpu_seconds: float = 0.0
    steps: int = 0
    rejected_steps: int = 0
    retries: int = 0
    iterations_mean: float = 0.0
    widest_step_angstrom: float = 0.0
    atoms: int = 0
    matched_atoms: int = 0
    matched_residues: int = 0
    sequence_identity: float = 0.0
    constraints: dict[str, Any] = field(default_factory=dict)
    bounds_widened: int = 0
    bounds_dropped: int = 0
    tolerance_angstrom: float = 0.0
    residual_angstrom: float = 0.0
    solver: str = ""
    last_rejection: str = ""
    interrupted: bool = False
    quality: dict[str, Any] = field(default_factory=dict)
    geometry: dict[str, Any] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    parameters: dict[str, Any] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """The report as plain values."""
        return asdict(self)


def target(
    start: Molecule,
    end: Molecule,
    output: str | Path,
    options: TargetOptions | None = None,
    *,
    force: bool = False,
    progress: Callable[[int, int], None] | None = None,
    parameters: Mapping[str, Any] | None = None,
) -> TargetReport:
    """Move a structure towards another one, into an HDF5 trajectory.

    The framework is that of the start, less the bounds that the end does not have. A cap on the
    RMSD from the end comes down step by step; each step is the projection on the cap, of least
    squares, and the resolution of all constraints. With ``options.mend`` residues that are
    implausible, and atoms that are too close, at the start or on the way, are mended as it goes.
    First all atoms that correspond are drawn, then
    backbones, then CA alone. The first frame is the start; each further one is nearer to the end
    than the one before, and no CA moves by more than 0.5 angstrom between two. KeyboardInterrupt
    ends the path early: what is done is kept, and the report says ``interrupted``.

    Args:
        start: where the path begins; its atoms, bonds and geometry are those of all frames.
        end: the target, of the same or a related sequence; atoms are matched by aligned residues
            and names.
        output: the trajectory, ``.h5``.
        options: how to go.
        force: replace an existing output.
        progress: called with the hundredths of the way done, and 100.
        parameters: further ones to store, such as how the molecules were read.

    Returns:
        The report; ``arrived`` tells whether the target was reached.

    Raises:
        InputError: an option or the output cannot be used, the structures have too little in
            common, or they are the same.
        TrajectoryError: the disk takes no more.
    """
    options = options or TargetOptions()
    options.check()
    check_output(output, force)
    pair = match(start, end)
    user = options.constraints.user if options.constraints is not None else ()
    fixed = fixed_atoms(start, user) if user else []
    if fixed:
        end = replace(end, positions=_laid_over_fixed(start, end, pair, fixed))
        pair = replace(pair, sites=_moving_sites(start, pair, fixed))
    rmsd = _ANGSTROM * _rmsd(
        start.positions[pair.first[pair.sites]], end.positions[pair.second[pair.sites]], bool(fixed)
    )
    if rmsd <= _CLOSE:
        raise InputError(
            f"{start.source} and {end.source} are the same conformation, {rmsd:.3f} angstrom apart "
            "by their CA atoms; give another target."
        )
    path = _Path(start, end, pair, fixed, Path(output), options, force, parameters or {})
    try:
        path.go(progress or (lambda done, asked: None))
    finally:
        path.close()
    path.measure()
    return path.report


def _rmsd(a: np.ndarray, b: np.ndarray, in_place: bool) -> float:
    if in_place:
        return float(np.sqrt(((a - b) ** 2).sum(axis=1).mean()))
    return _core.superposed_rmsd(np.ascontiguousarray(a), np.ascontiguousarray(b))


def _laid_over_fixed(start: Molecule, end: Molecule, pair: Match, fixed: list[int]) -> np.ndarray:
    """The end's positions where its part that corresponds to the fixed atoms is over these."""
    still = np.isin(pair.first, fixed)
    weights = still.astype(float)
    if still.sum() < 3:
        weights += 1e-3  # too few to tell the rotation: the rest has a say
    here, there = start.positions[pair.first], end.positions[pair.second]
    return rigid_move(there, here, weights)(end.positions)


def _moving_sites(start: Molecule, pair: Match, fixed: list[int]) -> np.ndarray:
    """What tells how near the end is: sites that move, else ligands, else all atoms.

    Raises:
        InputError: nothing that has a target can move.
    """
    everything = np.arange(len(pair.first), dtype=np.int32)
    for some in (pair.sites, pair.ligands, everything):
        moving = some[~np.isin(pair.first[some], fixed)]
        if len(moving):
            return moving
    raise InputError(
        f"All {len(everything)} atoms of {start.source} that have a target are fixed; select fewer."
    )


class _Path:
    """One path: its framework, the writer, and the report that grows."""

    def __init__(
        self,
        start: Molecule,
        end: Molecule,
        pair: Match,
        fixed: list[int],
        output: Path,
        options: TargetOptions,
        force: bool,
        parameters: Mapping[str, Any],
    ):
        self.start, self.end, self.pair = start, end, pair
        self.output, self.options = output, options
        self.fixed = fixed
        there = placed(start, end, pair)
        if fixed:
            there[fixed] = start.positions[fixed]
        self.carried = self._carried_atoms()
        self.joints = np.concatenate([pair.first, self.carried]).astype(np.int32)
        self.places = np.ascontiguousarray(
            np.concatenate([end.positions[pair.second], there[self.carried]])
        )
        whole = build_framework(
            start,
            contact_scale=options.contact_scale,
            heavy_allowance=options.heavy_allowance_angstrom / _ANGSTROM,
            planarity_degree=options.planarity_degree,
            constraints=options.constraints,
            conformations=[there],
        )
        self.framework, bounds = _core.common_framework(
            whole,
            start.positions,
            np.arange(len(start), dtype=np.int32),
            there,
            box_vectors=start.box_vectors,
        )
        # what resolves this one within the tolerance never exceeds a bound of the other
        self.held_framework = self.framework.tightened(None, options.tolerance_angstrom / _ANGSTROM)
        self._plan_backbone()
        self.report = TargetReport(
            atoms=len(start),
            matched_atoms=len(pair.first),
            matched_residues=pair.residues,
            sequence_identity=pair.identity,
            constraints=self.framework.constraint_counts(),
            bounds_widened=bounds["widened"],
            bounds_dropped=bounds["dropped"],
            tolerance_angstrom=options.tolerance_angstrom,
            notes=[*start.notes, *end.notes, *self._ligand_notes()],
            parameters={
                **asdict(options),
                **parameters,
                "input": start.source,
                "input_hash": start.source_hash,
                "target": end.source,
                "target_hash": end.source_hash,
                "version": __version__,
            },
        )
        self.writer = self._make_writer(force)
        self.last: np.ndarray | None = None  # sites of the last frame

    def _carried_atoms(self) -> np.ndarray:
        """Heavy atoms of ligands without an end, which go with what is around them."""
        alone = set(self.pair.alone[0])
        atoms = [
            atom.index
            for residue in self.start.topology.residues()
            if residue_label(residue) in alone and site_of(residue) is None
            for atom in residue.atoms()
            if atom.element.atomic_number > 1
        ]
        atoms = np.array(atoms, dtype=np.int32)
        return atoms[~np.isin(atoms, self.pair.first)]

    def _ligand_notes(self) -> list[str]:
        ours, theirs = self.pair.alone
        notes = []
        if ours:
            notes.append(
                f"{self.end.source} has nothing that corresponds to {', '.join(ours[:5])}, which "
                "goes with what is around it."
            )
        if theirs:
            notes.append(f"{', '.join(theirs[:5])} of {self.end.source} was left out.")
        return notes

    def _make_writer(self, force: bool) -> TrajectoryWriter:
        parameters = self.report.parameters
        return TrajectoryWriter(
            self.output,
            self.start.topology,
            observables=_OBSERVABLES,
            parameters=parameters,
            attributes={
                "version": parameters["version"],
                "seed": self.options.seed,
                "input": parameters["input"],
                "input_hash": parameters["input_hash"],
            },
            arrays={
                "input_positions": self.start.positions,
                "target_atoms": self.pair.first,
                "target_positions": self.places[: len(self.pair.first)],
            },
            framework=framework_arrays(self.framework),
            periodic=self.start.box_vectors is not None,
            version=parameters["version"],
            force=force,
        )

    def _plan_backbone(self) -> None:
        """The guide, and the stages: weights of all atoms, of backbones, of sites, and of these
        once more without mending. (4, n)
        """
        pair = self.pair
        stages = np.zeros((4, len(self.joints)))
        stages[0] = 1
        stages[1, pair.backbone] = 1
        stages[1, pair.ligands] = 1
        self.guide, self.stages = None, stages
        own = torsions_of(self.start) if self.options.mend else None
        other = torsions_of(self.end) if self.options.mend else None
        if own is not None and other is not None:
            ours = dict(zip(pair.second.tolist(), pair.first.tolist(), strict=True))
            density = zip(other.atoms[:, 2].tolist(), other.density.tolist(), strict=True)
            self.guide = make_guide(own, {ours[ca]: value for ca, value in density if ca in ours})
            # what is implausible in the end itself is no target
            stages[:, : len(pair.second)][:, np.isin(pair.second, outlier_atoms(other))] = 0
        stages[2:, pair.ligands] = _CARRIED
        stages[:, len(pair.first) :] = _CARRIED
        stages[2:, pair.sites] = 1
        if self.fixed:
            stages[:, np.isin(self.joints, self.fixed)] = 0
            empty = stages.sum(axis=1) == 0
            stages[empty] = stages[2]

    def go(self, progress: Callable[[int, int], None]) -> None:
        """Walk the path, and count and time what was done, also where that ends early."""
        options, report, pair = self.options, self.report, self.pair
        began = time.process_time()
        sites = pair.first[pair.sites]
        targets = np.ascontiguousarray(self.places[pair.sites])
        first = _rmsd(self.start.positions[sites], targets, bool(self.fixed))
        report.rmsd_start_angstrom = report.rmsd_end_angstrom = first * _ANGSTROM
        whole = _rmsd(self.start.positions[self.joints], self.places, bool(self.fixed))
        still = {"iterations": 0, "bar_visits": 0, "residual": 0.0, "converged": 1}
        self._write(self.start.positions, 0, {**still, "rmsd": first, "target_rmsd": whole}, sites)

        def take(steps: int, positions: np.ndarray, resolved: dict[str, Any]) -> None:
            report.residual_angstrom = max(
                report.residual_angstrom, resolved["residual_nm"] * _ANGSTROM
            )
            self._write(positions, steps, resolved, sites)
            progress(round(100 * (1 - resolved["rmsd"] / first)), 100)

        rounding = rounding_of(self.framework, self.start.positions).nanometers
        asked = options.tolerance_angstrom / _ANGSTROM
        try:
            done = _core.approach(
                self.held_framework,
                self.start.positions,
                take,
                joints=self.joints,
                target=self.places,
                stages=self.stages,
                guide=self.guide,
                mended_stages=3 if options.mend else 0,
                sites=pair.sites,
                motion=_core.MotionSettings("momentum", options.random_angstrom / _ANGSTROM),
                wander=options.variant == "random",
                step=options.step_angstrom / _ANGSTROM,
                spacing=options.spacing_angstrom / _ANGSTROM,
                widest=_WIDEST / _ANGSTROM,
                close=min(_CLOSE, options.arrive_angstrom) / _ANGSTROM,
                arrived=options.arrive_angstrom / _ANGSTROM,
                retries=options.retries,
                solver=options.solver,
                max_iterations=options.max_iterations,
                absolute_tolerance=max(asked - 2 * rounding, asked / 2),
                seed=options.seed,
                box_vectors=self.start.box_vectors,
            )
        except KeyboardInterrupt:
            report.interrupted = True
            return
        finally:
            report.cpu_seconds = time.process_time() - began
            report.frames = len(self.writer)
        report.rmsd_end_angstrom = done["rmsd_end"] * _ANGSTROM
        report.all_rmsd_end_angstrom = done["target_rmsd_end"] * _ANGSTROM
        report.arrived = done["arrived"]
        report.interrupted = done["interrupted"]
        for name in ("steps", "rejected_steps", "retries", "solver", "last_rejection"):
            setattr(report, name, done[name])
        if report.steps:
            report.iterations_mean = float(done["iterations"].mean())

    def _write(
        self, positions: np.ndarray, step: int, resolved: Mapping[str, Any], sites: np.ndarray
    ) -> None:
        kept = {name: resolved[name] for name in _OBSERVABLES}
        self.writer.append(positions, step * _STEP_SIZE, step, kept, box=self.start.box_vectors)
        if self.last is not None:
            moved = float(np.linalg.norm(positions[sites] - self.last, axis=1).max())
            widest = max(self.report.widest_step_angstrom, moved * _ANGSTROM)
            self.report.widest_step_angstrom = widest
        self.last = positions[sites]

    def close(self) -> None:
        """Complete the file, also where an interruption comes just then."""
        try:
            self.writer.close()
        except KeyboardInterrupt:
            self.report.interrupted = True
            self.writer.close()

    def measure(self) -> None:
        """Measure the frames that were written, as the file has them."""
        try:
            check = _core.GeometryCheck(
                self.framework,
                self.start.positions,
                peptide_torsions(self.start),
                absolute_tolerance=self.options.tolerance_angstrom / _ANGSTROM,
            )
            with Trajectory(self.output) as trajectory:
                for frame in trajectory:
                    check.add(frame.positions.astype(np.float64), self.start.box_vectors)
            self.report.geometry = geometry_dict(check.report())
            self.report.quality = quality(self.output).as_dict()
        except KeyboardInterrupt:
            self.report.interrupted = True
