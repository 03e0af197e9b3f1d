"""The work of an experiment: tasks on threads, finished ones into the journal."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass

import numpy as np

from .. import _core
from .frames import write_frames
from .journal import Journal
from .load import Case
from .outputs import write_text
from .result_set import ResultSet, SetEntry
from .runs import TaskRuns, iterations_csv
from .sources import refusals
from .technique import TREE_ORDERS, Technique


@dataclass(frozen=True, eq=False)
class Run:
    """The tasks of an experiment: a structure and a technique each."""

    results: ResultSet
    cases: list[Case]
    techniques: list[Technique]
    verlet: str
    frames: bool
    journal: Journal

    def tasks(self) -> list[tuple[Case, Technique]]:
        """In the order of the set, then of the techniques. Tree orders are left out on classes
        with cycles, so that all techniques of a class are tried on the same structures."""
        cyclic = {case.entry.class_name for case in self.cases if case.has_cycles}
        return [
            (case, technique)
            for case in self.cases
            for technique in self.techniques
            if not (technique.order in TREE_ORDERS and case.entry.class_name in cyclic)
        ]

    def work(self, threads: int, progress: Callable[[int, int], None]) -> int:
        """Do what is not finished; returns how many tasks were."""
        everything = self.tasks()
        todo = [(c, t) for c, t in everything if not self._is_finished(c, t)]
        before = done = len(everything) - len(todo)
        progress(done, len(everything))
        with ThreadPoolExecutor(threads) as pool:
            futures = {pool.submit(self._resolve, c, t) for c, t in todo}
            try:
                for future in as_completed(futures):
                    self._finish(*future.result())
                    futures.discard(future)
                    done += 1
                    progress(done, len(everything))
            except BaseException:
                # those at work end, the others never start; what ended is kept
                pool.shutdown(cancel_futures=True)
                for future in futures:
                    if not future.cancelled() and future.exception() is None:
                        self._finish(*future.result())
                raise
        return before

    def _is_finished(self, case: Case, technique: Technique) -> bool:
        folder = self.results.folder / case.entry.technique_folder(technique)
        files = ["iterations.csv"] + ["frames.h5"] * self.frames
        there = all((folder / file).is_file() for file in files)
        return there and task_name(case.entry, technique) in self.journal.finished

    def _resolve(self, case: Case, technique: Technique) -> tuple[Case, Technique, dict, list]:
        """One task; most of it outside Python's lock."""
        done: dict[str, list] = {k: [] for k in ("iterations", "bar_visits", "converged")}
        done["residual"], frames = [], []
        for force_set, seed in zip(case.forces, case.seeds, strict=True):
            with refusals():
                part = _core.resolve_forces(
                    case.structure,
                    force_set,
                    technique.order,
                    technique.weighting,
                    technique.solver,
                    self.verlet,
                    seed,
                    frames=self.frames,
                )
            for key, values in done.items():
                values.extend(np.asarray(part[key]).tolist())
            if self.frames:
                frames.extend(np.asarray(part["frames"]))
        return case, technique, done, frames

    def _finish(self, case: Case, technique: Technique, done: dict, frames: list) -> None:
        """Write what a task found; its journal line comes last. Only the main thread does this:
        HDF5 is not made for several."""
        runs = runs_of(case, technique, done)
        folder = self.results.folder / case.entry.technique_folder(technique)
        folder.mkdir(parents=True, exist_ok=True)
        if self.frames:
            about = {"order": technique.order, "weighting": technique.weighting}
            write_frames(folder / "frames.h5", case.structure, frames, done, about, force=True)
        write_text(folder / "iterations.csv", iterations_csv(runs))
        self.journal.add(task_name(case.entry, technique), done)

    def gather(self) -> list[TaskRuns]:
        """All tasks from the journal, in their order."""
        return [
            runs_of(c, t, self.journal.finished[task_name(c.entry, t)]) for c, t in self.tasks()
        ]


def task_name(entry: SetEntry, technique: Technique) -> str:
    return f"{entry.structure.as_posix()}|{technique.order}|{technique.weighting}|" + (
        technique.solver
    )


def runs_of(case: Case, technique: Technique, done: dict) -> TaskRuns:
    return TaskRuns(
        case.entry,
        technique,
        case.table,
        np.array(done["iterations"], dtype=np.int64),
        np.array(done["bar_visits"], dtype=np.int64),
        np.array(done["converged"], dtype=bool),
        np.array(done["residual"], dtype=np.float64),
    )
