"""The experiment: every technique on every structure and force of a set."""

import hashlib
import json
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..version import __version__
from .cells import Cells, make_cells
from .claims import Claim, judge
from .journal import Journal, is_journal
from .load import Case, load_case
from .outputs import write_outputs
from .result_set import ResultSet, read_set, write_results
from .run import Run
from .runs import TaskRuns
from .technique import all_techniques

_JOURNAL = "journal.jsonl"


@dataclass(frozen=True, eq=False)
class ExperimentReport:
    """What an experiment found; its files are in ``folder``.

    Attributes:
        folder: where the report is; ``index.html`` is its face.
        about: the set and the parameters.
        tasks: what was resolved, a structure and a technique each, with arrays over the forces.
        claims: T1 to T7.
        done_before: tasks that an earlier run had finished.
    """

    folder: Path
    about: dict[str, Any]
    tasks: list[TaskRuns] = field(repr=False)
    claims: dict[str, Claim] = field(repr=False)
    done_before: int = 0

    @property
    def table(self) -> Cells:
        """Statistics by class and technique."""
        return make_cells(self.tasks)

    @property
    def cells(self) -> list[dict[str, Any]]:
        """A record for each class and technique; ``pandas.DataFrame(report.cells)``."""
        return self.table.records()

    def records(self) -> list[dict[str, Any]]:
        """A record for each force under each technique, as in runs.csv."""
        return [record for task in self.tasks for record in task.records()]

    def as_dict(self) -> dict[str, Any]:
        """The object that ``ragdoll experiment --json`` prints."""
        return {
            "report": str(self.folder),
            **self.about,
            "runs": sum(len(task.iterations) for task in self.tasks),
            "cells": self.cells,
            "claims": {name: claim.as_dict() for name, claim in self.claims.items()},
        }


def experiment(
    set_folder: str | Path,
    report_folder: str | Path,
    *,
    orders: Sequence[str] | None = None,
    weightings: Sequence[str] | None = None,
    solvers: Sequence[str] | None = None,
    verlet: str = "affected",
    tolerance: float | None = None,
    scale: float = 1.0,
    max_iterations: int | None = None,
    frames: bool = False,
    threads: int | None = None,
    seed: int = 0,
    force: bool = False,
    progress: Callable[[int, int], None] = lambda done, asked: None,
) -> ExperimentReport:
    """Resolve every force of a set by every technique, and write a report.

    What is finished is journaled in the report's folder: the same call goes on where an earlier
    one was stopped, and comes to the same result. The numbers depend on the set, the parameters
    and the seed, not on the threads. KeyboardInterrupt leaves what is done in the journal.

    Args:
        set_folder: a set with its ``results.xml``.
        report_folder: where the report goes; made if it is not there.
        orders, weightings, solvers: techniques are all their combinations; all orders, the
            thesis' three weightings and ``ordered`` by default. Tree orders are left out on
            classes with cycles.
        verlet: ``affected`` or ``all``.
        tolerance, max_iterations: in the place of the force files'.
        scale: what every force is multiplied by.
        frames: write ``frames.h5`` into the technique folders.
        threads: how many work at once; all cores by default.
        seed: of the random orders.
        force: replace another experiment in the report's folder.
        progress: called with the tasks done and all tasks.

    Raises:
        InputError: the set or an option cannot be used, or the folder holds something else.
    """
    techniques = all_techniques(orders, weightings, solvers)
    _check_options(verlet, tolerance, scale, max_iterations, threads)
    results = read_set(set_folder)
    report_folder = _folder(Path(report_folder), force)
    cases = [
        load_case(
            results,
            entry,
            seed=seed,
            tolerance=tolerance,
            scale=scale,
            max_iterations=max_iterations,
        )
        for entry in results.entries
    ]
    about = {
        "set_seed": results.seed,
        "seed": seed,
        "structures": len(cases),
        "force_files": sum(len(case.forces) for case in cases),
        "techniques": [technique.name for technique in techniques],
        "verlet": verlet,
        "tolerance": sorted({forces.tolerance for case in cases for forces in case.forces}),
        "max_iterations": sorted(
            {forces.max_iterations for case in cases for forces in case.forces}
        ),
        "scale": scale,
        "frames": frames,
        "version": __version__,
    }
    with Journal(report_folder / _JOURNAL, _fingerprint(cases, about), about, force) as journal:
        run = Run(results, cases, techniques, verlet, frames, journal)
        done_before = run.work(threads or _cores(), progress)
        tasks = run.gather()
    _name_techniques(results, tasks)
    report = ExperimentReport(report_folder, about, tasks, judge(tasks), done_before)
    write_outputs(report)
    return report


def _check_options(verlet, tolerance, scale, max_iterations, threads) -> None:
    if verlet not in ("affected", "all"):
        raise InputError(f"--verlet '{verlet}' is not known; choose affected or all.")
    for flag, value in (("--tolerance", tolerance), ("--scale", scale)):
        if value is not None and not (np.isfinite(value) and value > 0):
            raise InputError(f"{flag} must be a positive number, not {value}.")
    for flag, count in (("--max-iterations", max_iterations), ("--threads", threads)):
        if count is not None and count < 1:
            raise InputError(f"{flag} must be 1 or more, not {count}.")


def _folder(folder: Path, force: bool) -> Path:
    """The report's folder, refused where something else is in it."""
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder} is a file; a report is a folder.")
    if not folder.exists() and not folder.absolute().parent.is_dir():
        raise InputError(f"The folder {folder.absolute().parent} does not exist; make it first.")
    folder.mkdir(exist_ok=True)
    if any(folder.iterdir()) and not is_journal(folder / _JOURNAL) and not force:
        raise InputError(
            f"{folder} is not empty and holds no experiment; give another folder, or --force."
        )
    return folder


def _cores() -> int:
    return len(os.sched_getaffinity(0))


def _fingerprint(cases: Sequence[Case], about: dict[str, Any]) -> str:
    """A hash of all that decides the results."""
    text = json.dumps([about, [[c.entry.class_name, c.hash] for c in cases]], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def _name_techniques(results: ResultSet, tasks: Sequence[TaskRuns]) -> None:
    """Add the technique folders to results.xml."""
    added = False
    by_structure = {entry.structure: entry for entry in results.entries}
    for task in tasks:
        folders = by_structure[task.entry.structure].techniques
        folder = task.entry.technique_folder(task.technique)
        if folder not in folders.values():
            folders[task.technique] = folder
            added = True
    if added:
        write_results(results.folder, results.entries, results.seed)
