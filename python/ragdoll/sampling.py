"""Sampling: random steps, each resolved by RagdollIntegrator; frames go to a trajectory."""

import math
import os
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import openmm
from openmm import unit

from . import _core
from .errors import InputError
from .framework import build_framework, framework_arrays, peptide_torsions
from .integrator import RagdollIntegrator
from .molecule import Molecule
from .system import make_system
from .trajectory import Trajectory, TrajectoryWriter, check_output
from .version import __version__

_ANGSTROM = 10.0  # per nm
_ATTEMPTS = 10  # per accepted step that was asked for
_MOST = 2**31 - 1  # of whatever is counted
_LARGEST_STEP = 100.0  # angstrom; larger than that, nothing is ever resolved

#: what every frame carries beside its positions
OBSERVABLES = {"iterations": int, "bar_visits": int, "residual": float, "converged": int}


@dataclass(frozen=True)
class SampleOptions:
    """How to sample. Lengths in the units that the names say.

    Attributes:
        frames: how many frames to write.
        stride: accepted steps from one frame to the next.
        step_angstrom: deviation per coordinate (gaussian) or radius (ball) of the random moves.
        perturbation: "gaussian" or "ball".
        order, weighting, solver, tolerance, max_iterations: of the resolution; the tolerance is
            relative to each constraint's length.
        contacts: whether atoms keep apart.
        contact_scale: of the sum of van der Waals radii.
        planarity_degree: how far planar units may turn or bend from the input.
        seed: decides all random numbers; 0 to 2^31 - 1.
        platform: OpenMM platform, "Reference" or "CPU".
    """

    frames: int = 20
    stride: int = 10
    step_angstrom: float = 0.1
    perturbation: str = "gaussian"
    order: str = "bfs_cycle"
    weighting: str = ".5/.5"
    solver: str = "auto"
    tolerance: float = 0.01
    max_iterations: int = 10000
    contacts: bool = True
    contact_scale: float = 0.85
    planarity_degree: float = 10.0
    seed: int = 0
    platform: str = "Reference"

    def check(self) -> None:
        """Raise InputError at the first option that makes no sense."""
        for name in ("frames", "stride", "max_iterations"):
            if not 1 <= getattr(self, name) <= _MOST:
                raise InputError(
                    f"{_flag(name)} must be from 1 to {_MOST}, not {getattr(self, name)}."
                )
        for name in ("step_angstrom", "tolerance"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise InputError(f"{_flag(name)} must be a positive number, not {value}.")
        if self.step_angstrom > _LARGEST_STEP:
            raise InputError(
                f"--step-angstrom must be at most {_LARGEST_STEP:g}, not {self.step_angstrom:g}."
            )
        if not 0 <= self.seed <= _MOST:
            raise InputError(f"--seed must be a whole number from 0 to {_MOST}, not {self.seed}.")
        if self.perturbation == "none":
            raise InputError("Sampling needs a --perturbation: gaussian or ball.")
        try:
            _core.check_order(self.order)
            _core.check_weighting(self.weighting)
            _core.check_perturbation(self.perturbation)
        except ValueError as error:
            raise InputError(f"{error}.") from None
        if self.solver not in _core.solver_names():
            known = ", ".join(_core.solver_names())
            raise InputError(f"solver '{self.solver}' is not known; choose one of: {known}.")
        if self.platform not in ("Reference", "CPU"):
            raise InputError(
                f"platform '{self.platform}' has no kernels of ragdoll; choose Reference or CPU."
            )


def _flag(name: str) -> str:
    return "--" + name.replace("_", "-")


def check_paths(source: str | Path, output: str | Path, force: bool) -> None:
    """Raise InputError if the output cannot be written, or would replace what is read."""
    exist = os.path.exists(source) and os.path.exists(output)
    if exist and os.path.samefile(source, output):
        raise InputError(f"{output} is the input; give another name for the output.")
    check_output(output, force)


@dataclass
class SampleReport:
    """What a run did; as_dict() is the object that ``ragdoll sample --json`` prints.

    ``geometry`` is measured on the written frames against the input.
    """

    atoms: int
    joints: int
    bars: int
    contacts: int
    chirality_centres: int
    class_: str
    cycle_rank: int
    components: int
    frames: int = 0
    frames_asked: int = 0
    steps: int = 0
    rejected_steps: int = 0
    iterations_mean: float = 0.0
    iterations_p99: float = 0.0
    seconds: float = 0.0
    frames_per_second: float = 0.0
    geometry: dict[str, Any] = field(default_factory=dict)
    interrupted: bool = False
    last_rejection: str = ""
    solver: str = ""
    notes: list[str] = field(default_factory=list)
    missing_atoms: dict[str, list[str]] = field(default_factory=dict)
    parameters: dict[str, Any] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """The report as plain values; the key of ``class_`` is ``class``."""
        return {name.removesuffix("_"): value for name, value in asdict(self).items()}


def sample(
    molecule: Molecule,
    output: str | Path,
    options: SampleOptions | None = None,
    *,
    force: bool = False,
    progress: Callable[[int, int], None] | None = None,
    parameters: Mapping[str, Any] | None = None,
) -> SampleReport:
    """Sample conformations of a molecule into an HDF5 trajectory.

    Each step moves every atom at random and resolves the framework; a step that does not converge
    or inverts a chirality centre is taken back and drawn anew from the last good frame. Every
    ``stride`` accepted steps make a frame; the input is not among them. At most 10 attempts are
    made for each accepted step that the frames need. KeyboardInterrupt ends the run early: what is
    done is kept, and the report says ``interrupted``.

    Args:
        molecule: where to start.
        output: the trajectory, ``.h5``.
        options: how to sample.
        force: replace an existing output.
        progress: called with the frames done and the frames asked for.
        parameters: further ones to store, such as how the molecule was read.

    Returns:
        The report; ``frames`` is smaller than ``frames_asked`` where frames are missing.

    Raises:
        InputError: an option, the molecule or the output cannot be used.
        TrajectoryError: the disk takes no more.
    """
    options = options or SampleOptions()
    options.check()
    check_paths(molecule.source, output, force)
    run = _Run(molecule, Path(output), options, force, parameters or {})
    try:
        run.sample(progress or (lambda done, asked: None))
    except KeyboardInterrupt:
        run.report.interrupted = True
    finally:
        run.close()
    run.measure()
    return run.report


class _Run:
    """One run: the simulation, the writer, and the report that grows."""

    def __init__(
        self,
        molecule: Molecule,
        output: Path,
        options: SampleOptions,
        force: bool,
        parameters: Mapping[str, Any],
    ):
        self.options = options
        self.parameters = parameters
        self.molecule = molecule
        self.output = output
        self.framework = build_framework(
            molecule,
            contacts=options.contacts,
            contact_scale=options.contact_scale,
            planarity_degree=options.planarity_degree,
        )
        self.report = self._first_report()
        self.integrator = self._make_integrator()
        self.context = openmm.Context(
            make_system(molecule, self.framework),
            self.integrator,
            openmm.Platform.getPlatformByName(options.platform),
        )
        self.context.setPositions(molecule.positions * unit.nanometer)
        self.iterations: list[int] = []
        self.writer = self._make_writer(force)

    def _first_report(self) -> SampleReport:
        framework = self.framework
        return SampleReport(
            atoms=len(self.molecule),
            joints=framework.joint_count,
            bars=framework.bar_count,
            contacts=framework.count_contacts(self.molecule.positions),
            chirality_centres=framework.chirality_count,
            class_=framework.class_name,
            cycle_rank=framework.cycle_rank,
            components=framework.component_count,
            frames_asked=self.options.frames,
            notes=list(self.molecule.notes),
            missing_atoms={gap.residue: list(gap.names) for gap in self.molecule.missing_atoms},
            parameters={
                **asdict(self.options),
                **self.parameters,
                "input": self.molecule.source,
                "input_hash": self.molecule.source_hash,
                "version": __version__,
                "openmm_version": openmm.Platform.getOpenMMVersion(),
            },
        )

    def _make_integrator(self) -> RagdollIntegrator:
        options = self.options
        settings = {
            "solver": options.solver,
            "order": options.order,
            "weighting": options.weighting,
            "tolerance": self._tolerance(),
        }
        # what core refuses (a tree order on cycles) is said before anything is written
        try:
            resolver = _core.Resolver(self.framework, **settings)
        except ValueError as error:
            raise InputError(f"{error}.") from None
        self.report.solver = resolver.solver
        return RagdollIntegrator(
            framework=self.framework,
            maxIterations=options.max_iterations,
            perturbation=options.perturbation,
            perturbationSize=options.step_angstrom / _ANGSTROM,
            seed=options.seed,
            rejectUnresolved=True,
            **settings,
        )

    def _tolerance(self) -> float:
        """The tolerance, less what rounding to the file's single precision may add."""
        rounding = np.abs(self.molecule.positions).max(initial=1.0) * 2.0**-24
        lengths = np.concatenate(
            [self.framework.bar_lengths, self.framework.close_pair_lengths, [0.1]]
        )
        margin = 2 * math.sqrt(3) * rounding / lengths.min()
        if 4 * margin > self.options.tolerance:
            self.report.notes.append(
                f"The file's single precision may add {margin:.1g} to the violations of "
                f"constraints, which is much beside a tolerance of {self.options.tolerance:g}."
            )
        return max(self.options.tolerance - 2 * margin, self.options.tolerance / 2)

    def _make_writer(self, force: bool) -> TrajectoryWriter:
        parameters = self.report.parameters
        return TrajectoryWriter(
            self.output,
            self.molecule.topology,
            observables=OBSERVABLES,
            parameters=parameters,
            attributes={
                "version": parameters["version"],
                "seed": self.options.seed,
                "input": parameters["input"],
                "input_hash": parameters["input_hash"],
            },
            arrays={"input_positions": self.molecule.positions},
            framework=framework_arrays(self.framework),
            periodic=self.molecule.box_vectors is not None,
            version=parameters["version"],
            force=force,
        )

    def sample(self, progress: Callable[[int, int], None]) -> None:
        """Take steps until the frames are there or the attempts are used up."""
        options, report = self.options, self.report
        most = _ATTEMPTS * options.frames * options.stride
        accepted = 0
        start = time.perf_counter()
        try:
            while report.frames < options.frames and report.steps < most:
                self.integrator.step(1)
                report.steps += 1
                self.iterations.append(self.integrator.getIterations())
                if not self.integrator.getAccepted():
                    report.rejected_steps += 1
                    report.last_rejection = (
                        f"{self.integrator.getStopReason()}: {self.integrator.getWorstConstraint()}"
                    )
                    continue
                accepted += 1
                if accepted % options.stride == 0:
                    self._write_frame()
                    report.frames = len(self.writer)
                    progress(report.frames, options.frames)
        finally:
            report.frames = len(self.writer)
            report.seconds = time.perf_counter() - start
            report.frames_per_second = report.frames / report.seconds if report.seconds else 0.0
            if self.iterations:
                report.iterations_mean = float(np.mean(self.iterations))
                report.iterations_p99 = float(np.percentile(self.iterations, 99))

    def _write_frame(self) -> None:
        state = self.context.getState(positions=True)
        integrator = self.integrator
        self.writer.append(
            state.getPositions(asNumpy=True).value_in_unit(unit.nanometer),
            state.getTime().value_in_unit(unit.picosecond),
            self.context.getStepCount(),
            {
                "iterations": integrator.getIterations(),
                "bar_visits": integrator.getBarVisits(),
                "residual": integrator.getResidual(),
                "converged": int(integrator.getConverged()),
            },
            box=self.molecule.box_vectors,
        )

    def close(self) -> None:
        """Complete the file, also where an interruption comes just then."""
        try:
            self.writer.close()
        except KeyboardInterrupt:
            self.report.interrupted = True
            self.writer.close()

    def measure(self) -> None:
        """Measure the frames that were written, as the file has them."""
        if self.report.frames == 0:
            return
        try:
            self._measure()
        except KeyboardInterrupt:
            self.report.interrupted = True

    def _measure(self) -> None:
        check = _core.GeometryCheck(
            self.framework,
            self.molecule.positions,
            peptide_torsions(self.molecule),
            self.options.tolerance,
        )
        with Trajectory(self.output) as trajectory:
            for frame in trajectory:
                check.add(frame.positions.astype(np.float64), self.molecule.box_vectors)
        self.report.geometry = geometry_dict(check.report())


def geometry_dict(measured: dict[str, Any]) -> dict[str, Any]:
    """What GeometryCheck measured, with lengths in angstrom."""
    return {
        "bond_rms_angstrom": measured["bond_rms"] * _ANGSTROM,
        "bond_max_angstrom": measured["bond_max"] * _ANGSTROM,
        "bond_max_relative": measured["bond_max_relative"],
        "bar_max_relative": measured["bar_max_relative"],
        "angle_rms_degree": measured["angle_rms_degree"],
        "omega_max_deviation_degree": measured["omega_max_deviation_degree"],
        "contact_violations": measured["contact_violations"],
        "contact_worst_angstrom": measured["contact_worst"] * _ANGSTROM,
        "chirality_inverted": measured["chirality_inverted"],
        "rmsd_last_angstrom": measured["rmsd_last"] * _ANGSTROM,
        "rmsd_max_angstrom": measured["rmsd_max"] * _ANGSTROM,
    }
