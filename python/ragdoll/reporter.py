"""An OpenMM reporter that writes the project's trajectories."""

# SPDX-License-Identifier: MIT
from __future__ import annotations

import os
import weakref
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from typing import Self

# observables that an integrator may offer: name in files, its getter, type
_OFFERED = (
    ("iterations", "getIterations", int),
    ("bar_visits", "getBarVisits", int),
    ("converged", "getConverged", int),
    ("residual", "getResidual", float),
)
_LARGEST_XML = 1 << 20  # an integrator's XML beyond this many characters is left out


class TrajectoryReporter:
    """Writes frames of a simulation: an HDF5 file for MDTraj, MDAnalysis, VMD and ourselves.

    Append it to ``simulation.reporters`` and call ``close()`` at the end, or use it as a context
    manager; otherwise it closes when it is collected or when Python ends.  With an integrator that
    has ``getIterations()``, ``getBarVisits()``, ``getConverged()`` and ``getResidual()`` these
    become observables of each frame; any other integrator works too.
    """

    def __init__(
        self,
        file: str | os.PathLike,
        reportInterval: int,
        enforcePeriodicBox: bool | None = None,
        velocities: bool = False,
        force: bool = False,
        precision: float | None = None,
        parameters: Mapping[str, Any] | None = None,
        attributes: Mapping[str, str | int | float] | None = None,
        framework: Mapping[str, Any] | None = None,
    ):
        """Prepare to report.

        file: the trajectory, usually ``NAME.h5``; reportInterval: steps between frames;
        enforcePeriodicBox: wrap molecules into the box (None: if the system is periodic);
        velocities: write them too; force: replace an existing file; precision: largest rounding
        error in nm (None: none); parameters, attributes, framework: see TrajectoryWriter; the
        integrator's name, step size and XML are added to the parameters.

        Raises TrajectoryUsageError if the file exists already or cannot be written.
        """
        from .trajectory import TrajectoryUsageError, check_output

        if int(reportInterval) < 1:
            raise TrajectoryUsageError(f"reportInterval must be at least 1, not {reportInterval}")
        check_output(file, force)
        self._file = os.fspath(file)
        self._interval = int(reportInterval)
        self._wrap = enforcePeriodicBox
        self._velocities = bool(velocities)
        self._options = {"force": force, "precision": precision, "framework": framework}
        self._options["attributes"] = attributes
        self._parameters = dict(parameters or {})
        self._offered: list[tuple[str, str, type]] = []
        self._writer = None
        self._finish = None

    def describeNextReport(self, simulation) -> dict[str, Any]:
        """When the next frame is due and what it needs, in the form OpenMM asks for."""
        steps = self._interval - simulation.currentStep % self._interval
        include = ["positions", "velocities"] if self._velocities else ["positions"]
        return {"steps": steps, "periodic": self._wrap, "include": include}

    def report(self, simulation, state) -> None:
        """Write a frame.  Raises TrajectoryError if the disk takes no more."""
        from openmm import unit

        if self._writer is None:
            self._start(simulation)
        integrator = simulation.integrator
        positions = state.getPositions(asNumpy=True)
        box = state.getPeriodicBoxVectors(asNumpy=True) if self._periodic else None
        self._writer.append(
            positions,
            state.getTime().value_in_unit(unit.picosecond),
            simulation.currentStep,
            {name: getattr(integrator, getter)() for name, getter, _ in self._offered},
            box,
            state.getVelocities(asNumpy=True) if self._velocities else None,
        )

    def _start(self, simulation) -> None:
        """Open the file, now that there is a simulation to tell of."""
        from .trajectory import TrajectoryWriter

        integrator = simulation.integrator
        self._offered = [offer for offer in _OFFERED if hasattr(integrator, offer[1])]
        self._periodic = simulation.system.usesPeriodicBoundaryConditions()
        self._writer = TrajectoryWriter(
            self._file,
            simulation.topology,
            observables={name: kind for name, _, kind in self._offered},
            parameters={**_describe(integrator), **self._parameters},
            periodic=self._periodic,
            velocities=self._velocities,
            **self._options,
        )
        self._finish = weakref.finalize(self, _close_in, os.getpid(), self._writer)

    def close(self) -> None:
        """Complete the file.  Raises TrajectoryError if there is no room; segments are kept."""
        if self._finish is not None:
            self._finish.detach()
            self._writer.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind, error, traceback) -> None:
        if self._finish is not None:
            self._finish.detach()
            self._writer.__exit__(kind, error, traceback)


def _close_in(process: int, writer) -> None:
    """Close, unless this is a forked copy of the process that writes."""
    if os.getpid() == process:
        writer.close()


def _describe(integrator) -> dict[str, Any]:
    """An integrator as JSON: class, step size in ps, XML if it has one of modest size."""
    from openmm import OpenMMException, XmlSerializer, unit

    step = integrator.getStepSize().value_in_unit(unit.picosecond)
    described = {"integrator": type(integrator).__name__, "step_size_ps": step}
    try:
        xml = XmlSerializer.serialize(integrator)
    except OpenMMException:  # some integrators cannot be serialized
        return described
    if len(xml) <= _LARGEST_XML:
        described["integrator_xml"] = xml
    return described
