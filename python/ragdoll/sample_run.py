"""One run of sampling: the walk, the writer, and the report that grows."""

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import asdict, replace
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
from .motion_options import symmetric_copies
from .quality_report import molecule_terms, quality
from .rounding import rounding_of
from .sample_options import SampleOptions
from .sample_report import ReplicaReport, SampleReport, geometry_dict
from .system import make_system
from .trajectory import Trajectory, TrajectoryWriter
from .version import __version__
from .walk_state import read_states, write_states

_ANGSTROM = 10.0  # per nm
_ATTEMPTS = 10  # per accepted step that was asked for
_STEP_SIZE = 0.001  # ps; what a step counts as in the file

Progress = Callable[[int, int], None]


class Run(ABC):
    """What all runs share."""

    #: what every frame carries beside its positions
    observables = {"iterations": int, "bar_visits": int, "residual": float, "converged": int}

    def __init__(
        self,
        molecule: Molecule,
        output: Path,
        options: SampleOptions,
        force: bool,
        parameters: Mapping[str, Any],
    ):
        self.options = options
        molecule = self._made_symmetric(molecule)
        self.molecule = molecule
        self.output = output
        self.framework = build_framework(
            molecule,
            contacts=options.contacts,
            contact_scale=options.contact_scale,
            planarity_degree=options.planarity_degree,
            constraints=options.constraints,
        )
        self.report = self._first_report(parameters)
        self.settings = self._resolver_settings()
        # what resolves this one within the tolerance never exceeds a bound of the other
        self.held_framework = self.framework.tightened(
            options.tolerance,
            None if options.tolerance_angstrom is None else options.tolerance_angstrom / _ANGSTROM,
        )
        # what core refuses (a tree order on cycles) is said before anything is written
        try:
            resolver = _core.Resolver(self.held_framework, **self.settings)
        except ValueError as error:
            raise InputError(f"{error}.") from None
        self.report.solver = resolver.solver
        self.report.parameters["solver_chosen"] = resolver.solver
        self.iterations: list[int] = []
        self.judge = None  # of frames, before they are written
        if not options.allow_low_quality:
            arrays = framework_arrays(self.framework)
            self.judge = options.limits.judge(molecule_terms(molecule, arrays))
        self.prepare()
        self.writer = self._make_writer(force)

    def _made_symmetric(self, molecule: Molecule) -> Molecule:
        """The molecule with copies placed as the first one says, where copies are to be alike."""
        self.symmetry = None
        if not self.options.motion.symmetric:
            return molecule
        copies = symmetric_copies(molecule, self.options.motion.symmetric)
        try:
            self.symmetry = _core.Symmetry(copies, molecule.positions)
        except ValueError as error:
            raise InputError(f"--symmetric: {error}.") from None
        off = self.symmetry.deviation(molecule.positions) * _ANGSTROM
        note = f"Copies were made alike; atoms moved by up to {off:.2f} Å."
        return replace(
            molecule,
            positions=self.symmetry.carry(molecule.positions),
            notes=[*molecule.notes, note],
        )

    @abstractmethod
    def prepare(self) -> None:
        """Make what the walk needs; raise InputError if that cannot be."""

    @abstractmethod
    def walk(self, progress: Progress) -> None:
        """Take steps until the frames are there or the attempts are used up."""

    def _first_report(self, parameters: Mapping[str, Any]) -> SampleReport:
        framework, options = self.framework, self.options
        return SampleReport(
            atoms=len(self.molecule),
            joints=framework.joint_count,
            bars=framework.bar_count,
            contacts=framework.count_contacts(self.molecule.positions) - len(framework.contacts),
            chirality_centres=framework.chirality_count,
            constraints=framework.constraint_counts(),
            class_=framework.class_name,
            cycle_rank=framework.cycle_rank,
            components=framework.component_count,
            tolerance=options.tolerance,
            tolerance_angstrom=options.tolerance_angstrom,
            precision=options.precision,
            solver_asked=options.solver,
            frames_asked=options.frames * (options.replicas or 1),
            notes=list(self.molecule.notes),
            missing_atoms={gap.residue: list(gap.names) for gap in self.molecule.missing_atoms},
            parameters={
                **asdict(options),
                **parameters,
                "input": self.molecule.source,
                "input_hash": self.molecule.source_hash,
                "version": __version__,
                "openmm_version": openmm.Platform.getOpenMMVersion(),
            },
        )

    def _resolver_settings(self) -> dict[str, Any]:
        """Of core's resolvers: solver, order, weighting, precision and the tolerance."""
        options = self.options
        return {
            "solver": self._solver(),
            "order": options.order,
            "weighting": options.weighting,
            "precision": options.precision,
            **self._tolerance(),
        }

    def _solver(self) -> str:
        """What thermal modes break is far across, which sweeps take long for."""
        options = self.options
        far = options.solver == "auto" and options.perturbation == "thermal"
        return "newton" if far else options.solver

    def _tolerance(self) -> dict[str, float]:
        """The tolerance, less what rounding to the file's single precision may add."""
        rounding = rounding_of(self.framework, self.molecule.positions)
        if self.options.tolerance_angstrom is None:
            name, asked, margin = "tolerance", self.options.tolerance, rounding.relative
            words = f"{margin:.1g} to the violations", f"a tolerance of {asked:g}"
        else:
            name, margin = "absolute_tolerance", rounding.nanometers
            asked = self.options.tolerance_angstrom / _ANGSTROM
            words = (
                f"{margin * _ANGSTROM:.1g} Å to the violations",
                f"a tolerance of {self.options.tolerance_angstrom:g} Å",
            )
        if 4 * margin > asked:
            self.report.notes.append(
                f"The file's single precision may add {words[0]} of constraints, which is much "
                f"beside {words[1]}."
            )
        return {name: max(asked - 2 * margin, asked / 2)}

    def _make_writer(self, force: bool) -> TrajectoryWriter:
        parameters = self.report.parameters
        return TrajectoryWriter(
            self.output,
            self.molecule.topology,
            observables=self.observables,
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

    def sample(self, progress: Progress) -> None:
        """Walk, and count and time what was done, also where that ends early."""
        report = self.report
        start = time.perf_counter()
        try:
            self.walk(progress)
        finally:
            report.frames = len(self.writer)
            report.seconds = time.perf_counter() - start
            report.frames_per_second = report.frames / report.seconds if report.seconds else 0.0
            report.rejected_share = report.rejected_steps / report.steps if report.steps else 0.0
            if len(self.iterations):
                report.iterations_mean = float(np.mean(self.iterations))
                report.iterations_p99 = float(np.percentile(self.iterations, 99))

    def write_frame(
        self, positions: np.ndarray, time_ps: float, step: int, observables: dict[str, Any]
    ) -> None:
        """Append a frame; ``observables`` also has residual_nm, which the file does not hold."""
        report = self.report
        report.residual = max(report.residual, observables["residual"])
        report.residual_angstrom = max(
            report.residual_angstrom, observables["residual_nm"] * _ANGSTROM
        )
        kept = {name: observables[name] for name in self.observables}
        self.writer.append(positions, time_ps, step, kept, box=self.molecule.box_vectors)
        report.frames = len(self.writer)

    def is_low(self, positions: np.ndarray) -> bool:
        """Whether a frame is below the limits of quality; it is counted then."""
        if self.judge is None:
            return False
        measure, words = self.judge.fault(positions, self.molecule.box_vectors)
        if not measure:
            return False
        low = self.report.low_frames
        low[measure] = low.get(measure, 0) + 1
        self.report.last_fault = words
        return True

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
        angstrom = self.options.tolerance_angstrom
        check = _core.GeometryCheck(
            self.framework,
            self.molecule.positions,
            peptide_torsions(self.molecule),
            tolerance=self.options.tolerance,
            absolute_tolerance=None if angstrom is None else angstrom / _ANGSTROM,
        )
        last: dict[int, np.ndarray] = {}  # frame of each replica
        with Trajectory(self.output) as trajectory:
            for frame in trajectory:
                positions = frame.positions.astype(np.float64)
                check.add(positions, self.molecule.box_vectors)
                last[frame.observables.get("replica", 0)] = positions
        self.report.geometry = geometry_dict(check.report())
        self.report.quality = quality(self.output).as_dict()
        for replica in self.report.replicas:
            if replica.replica in last:
                rmsd = _core.superposed_rmsd(last[replica.replica], self.molecule.positions)
                replica.rmsd_last_angstrom = rmsd * _ANGSTROM


class IntegratorRun(Run):
    """One walk, by RagdollIntegrator in a Context of OpenMM."""

    def prepare(self) -> None:
        """Make the integrator and its Context."""
        options = self.options
        settings = dict(self.settings)
        settings["absoluteTolerance"] = settings.pop("absolute_tolerance", 0)
        self.integrator = RagdollIntegrator(
            _STEP_SIZE,
            self.held_framework,
            maxIterations=options.max_iterations,
            perturbation=options.perturbation,
            perturbationSize=options.step_angstrom / _ANGSTROM,
            seed=options.seed,
            rejectUnresolved=True,
            **settings,
        )
        self.context = openmm.Context(
            make_system(self.molecule, self.held_framework),
            self.integrator,
            openmm.Platform.getPlatformByName(options.platform),
        )
        self.context.setPositions(self.molecule.positions * unit.nanometer)

    def walk(self, progress: Progress) -> None:
        """Take steps until the frames are there or the attempts are used up."""
        options, report = self.options, self.report
        most = _ATTEMPTS * options.frames * options.stride
        accepted = 0
        while report.frames < options.frames and report.steps < most:
            self.integrator.step(1)
            report.steps += 1
            self.iterations.append(self.integrator.getIterations())
            if not self.integrator.getAccepted():
                report.rejected_steps += 1
                report.last_rejection = self._rejection()
                continue
            accepted += 1
            if accepted % options.stride == 0:
                self._write_frame()
                progress(report.frames, options.frames)

    def _rejection(self) -> str:
        integrator = self.integrator
        if integrator.getConverged():
            return f"{integrator.getInvertedCentres()} inverted centre(s)"
        return f"{integrator.getStopReason()}: {integrator.getWorstConstraint()}"

    def _write_frame(self) -> None:
        state = self.context.getState(positions=True)
        integrator = self.integrator
        positions = state.getPositions(asNumpy=True).value_in_unit(unit.nanometer)
        if self.is_low(positions):
            return
        self.write_frame(
            positions,
            state.getTime().value_in_unit(unit.picosecond),
            self.context.getStepCount(),
            {
                "iterations": integrator.getIterations(),
                "bar_visits": integrator.getBarVisits(),
                "residual": integrator.getResidual(),
                "residual_nm": integrator.getResidualLength().value_in_unit(unit.nanometer),
                "converged": int(integrator.getConverged()),
            },
        )


class ReplicaRun(Run):
    """Walkers side by side, in core."""

    observables = {**Run.observables, "replica": int, "seed": int}

    def prepare(self) -> None:
        """Name the replicas' seeds, and make what moves them."""
        options = self.options
        seeds = [options.seed + k for k in range(options.replicas or 1)]
        self.report.parameters["replica_seeds"] = seeds
        self.report.replicas = [ReplicaReport(k, seed) for k, seed in enumerate(seeds)]
        self.states: list[dict[str, Any]] = []
        self.motion = options.motion.for_core(
            options.perturbation, options.step_angstrom, self.molecule, self.framework
        )

    def go_on_from(self, path: Path) -> None:
        """Take up the states of an earlier run."""
        self.states = read_states(path, self.report.parameters, len(self.molecule))
        self.report.parameters["restart"] = str(path)

    def keep_states(self, path: Path) -> None:
        """Write the states that the walkers ended in."""
        if self.states:
            write_states(path, self.states, self.report.parameters)

    def walk(self, progress: Progress) -> None:
        """Walk all replicas; frames come round by round."""
        options, report = self.options, self.report

        def take(replica: int, steps: int, positions: np.ndarray, resolved: dict[str, Any]) -> None:
            whose = {"replica": replica, "seed": options.seed + replica}
            self.write_frame(positions, steps * _STEP_SIZE, steps, {**resolved, **whose})
            progress(report.frames, report.frames_asked)

        done = _core.walk(
            self.held_framework,
            self.molecule.positions,
            take,
            walkers=options.replicas or 1,
            frames=options.frames,
            stride=options.stride,
            attempts=_ATTEMPTS,
            motion=self.motion,
            symmetry=self.symmetry,
            states=self.states,
            max_iterations=options.max_iterations,
            seed=options.seed,
            threads=options.threads or 0,
            box_vectors=self.molecule.box_vectors,
            judge=self.judge,
            **self.settings,
        )
        self.states = [walker["state"] for walker in done["walkers"]]
        for replica, walker in zip(report.replicas, done["walkers"], strict=True):
            replica.frames = walker["frames"]
            replica.steps = walker["steps"]
            replica.rejected_steps = walker["rejected_steps"]
            replica.last_rejection = walker["last_rejection"]
            if replica.steps:
                replica.iterations_mean = float(walker["iterations"].mean())
            report.last_rejection = replica.last_rejection or report.last_rejection
            replica.low_frames = sum(walker["low_frames"].values())
            report.last_fault = walker["last_fault"] or report.last_fault
            for measure, count in walker["low_frames"].items():
                report.low_frames[measure] = report.low_frames.get(measure, 0) + count
        self.iterations = np.concatenate([walker["iterations"] for walker in done["walkers"]])
        report.steps = sum(replica.steps for replica in report.replicas)
        report.rejected_steps = sum(replica.rejected_steps for replica in report.replicas)
        report.interrupted = done["interrupted"]
        for name in ("solver", "instructions", "lanes", "threads"):
            setattr(report, name, done[name])
