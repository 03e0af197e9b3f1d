"""Cells: the statistics of a technique over all forces of a class."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .runs import TaskRuns
from .statistics import Statistics, counted_iterations, statistics_of
from .technique import REVERSE_ORDERS, Technique


@dataclass(frozen=True)
class View:
    """Which forces count, and how.

    Attributes:
        name: for people.
        sweeps: how many iterations one pass of a reverse order counts as: 1, or 2 as forward
            and backward.
        sizes: least and most |F|/m dt^2 of the forces that count, in mean bar lengths.
        resolved_only: leave out what a technique did not resolve.
    """

    name: str = "as the specification counts"
    sweeps: int = 1
    sizes: tuple[float, float] = (0.0, float("inf"))
    resolved_only: bool = False


@dataclass(frozen=True)
class Cell:
    """One class under one technique."""

    class_name: str
    technique: Technique
    structures: int
    statistics: Statistics

    def as_dict(self) -> dict[str, Any]:
        """A record of plain values."""
        return {
            "class": self.class_name,
            "order": self.technique.order,
            "weighting": self.technique.weighting,
            "solver": self.technique.solver,
            "structures": self.structures,
            **self.statistics.as_dict(),
        }


class Cells:
    """Cells by class and technique, in the order of the set and the techniques."""

    def __init__(self, cells: Iterable[Cell]):
        self._cells = {(cell.class_name, cell.technique): cell for cell in cells}

    def __iter__(self):
        return iter(self._cells.values())

    def __len__(self) -> int:
        return len(self._cells)

    @property
    def classes(self) -> list[str]:
        """Classes, each once."""
        return list(dict.fromkeys(class_name for class_name, _ in self._cells))

    @property
    def techniques(self) -> list[Technique]:
        """Techniques, each once."""
        return list(dict.fromkeys(technique for _, technique in self._cells))

    def get(self, class_name: str, order: str, weighting: str) -> Statistics | None:
        """Statistics of a cell of the ordered solver; None where there are no forces."""
        cell = self._cells.get((class_name, Technique(order, weighting)))
        return cell.statistics if cell and cell.statistics.forces else None

    def of_class(self, class_name: str) -> list[Cell]:
        """The cells of a class."""
        return [cell for cell in self if cell.class_name == class_name]

    def records(self) -> list[dict[str, Any]]:
        """A record for each cell."""
        return [cell.as_dict() for cell in self]


def counted(runs: TaskRuns, view: View) -> tuple[np.ndarray, np.ndarray]:
    """Iterations as a view counts them, and which forces it counts. (F,) int64, (F,) bool"""
    numbers = counted_iterations(runs.iterations, runs.converged, runs.forces.max_iterations)
    if runs.technique.order in REVERSE_ORDERS:
        numbers = numbers * view.sweeps
    sizes = runs.forces.sizes
    chosen = (sizes >= view.sizes[0]) & (sizes <= view.sizes[1])
    if view.resolved_only:
        chosen &= runs.converged
    return numbers, chosen


def make_cells(tasks: Sequence[TaskRuns], view: View | None = None) -> Cells:
    """Gather runs into cells, as a view counts them; by default as the specification does."""
    view = view or View()
    groups: dict[tuple[str, Technique], list[TaskRuns]] = {}
    for runs in tasks:
        groups.setdefault((runs.entry.class_name, runs.technique), []).append(runs)
    cells = []
    for (class_name, technique), group in groups.items():
        numbers, converged, visits = [], [], []
        for runs in group:
            iterations, chosen = counted(runs, view)
            numbers.append(iterations[chosen])
            converged.append(runs.converged[chosen])
            visits.append(runs.bar_visits[chosen])
        statistics = statistics_of(
            np.concatenate(numbers), np.concatenate(converged), np.concatenate(visits)
        )
        cells.append(Cell(class_name, technique, len(group), statistics))
    return Cells(cells)


def cells_csv(cells: Cells) -> list[list]:
    """Rows of cells.csv, the first with the names of the columns."""
    records = cells.records()
    if not records:
        return [[]]
    rows = [list(records[0])]
    rows.extend(["" if v is None else v for v in record.values()] for record in records)
    return rows
