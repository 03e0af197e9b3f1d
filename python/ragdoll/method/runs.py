"""The runs of an experiment: every force under every technique, as columns."""

import csv
import io
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from .result_set import SetEntry
from .technique import Technique

_RESULTS = (
    "iterations",
    "bar_visits",
    "converged",
    "residual",
    "joint",
    "size",
    "force_file",
)
_COLUMNS = ("class", "structure", "force", "order", "weighting", "solver", *_RESULTS)


@dataclass(frozen=True, eq=False)
class ForceTable:
    """The forces of one structure, in the order of its force files. (F,) each"""

    files: list[str]  #: name of the force's file
    joints: list[str]  #: id of the forced joint
    sizes: np.ndarray  #: |F|/m dt^2 in mean bar lengths
    max_iterations: np.ndarray  #: int64


@dataclass(frozen=True, eq=False)
class TaskRuns:
    """One structure under one technique; F forces.

    ``iterations`` (F,) int64 are as they were made; an unresolved force may have ended early.
    """

    entry: SetEntry
    technique: Technique
    forces: ForceTable = field(repr=False)
    iterations: np.ndarray
    bar_visits: np.ndarray
    converged: np.ndarray
    residual: np.ndarray

    def rows(self) -> Iterator[list]:
        """Rows of runs.csv."""
        technique, table, name = self.technique, self.forces, self.entry.name
        for k in range(len(self.iterations)):
            yield [
                self.entry.class_name,
                name,
                k + 1,
                technique.order,
                technique.weighting,
                technique.solver,
                int(self.iterations[k]),
                int(self.bar_visits[k]),
                int(self.converged[k]),
                repr(float(self.residual[k])),
                table.joints[k],
                f"{table.sizes[k]:.6g}",
                table.files[k],
            ]

    def records(self) -> Iterator[dict]:
        """The rows with the names of their columns."""
        for row in self.rows():
            yield dict(zip(_COLUMNS, row, strict=True))


def csv_text(rows, columns=_COLUMNS) -> str:
    """Rows as text, under their columns."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(rows)
    return text.getvalue()


def iterations_csv(runs: TaskRuns) -> str:
    """The text of a technique folder's iterations.csv."""
    return csv_text(([row[2], *row[6:]] for row in runs.rows()), ("force", *_RESULTS))
