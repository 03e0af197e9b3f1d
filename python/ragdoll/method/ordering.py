"""The order in which a structure's bars are resolved."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from .. import _core, _method_files
from ..errors import InputError
from .sources import Structure, joint_of, refusals, structure_of
from .technique import TREE_ORDERS


@dataclass(frozen=True, eq=False)
class BarOrder:
    """The order of the first iteration.

    Attributes:
        name: of the order, or ``file:PATH``.
        root: id of the joint where it starts; empty for the bars of a file or at random.
        bars: (n, 2) int32 joints of each visit, the nearer end first.
        closes_cycle: (n,) bool, whether the visit is one of a problem constraint.
        ids: names of the joints.
    """

    name: str
    root: str
    bars: np.ndarray
    closes_cycle: np.ndarray
    ids: list[str] = field(repr=False)

    @property
    def problem(self) -> np.ndarray:
        """Problem constraints in order, the nearer end first. (m, 2) int32"""
        return self.bars[self.closes_cycle]

    def records(self) -> list[dict[str, Any]]:
        """A record for each visit: position, near, far, problem."""
        return [
            {"visit": k, "near": self.ids[p], "far": self.ids[q], "problem": bool(closes)}
            for k, ((p, q), closes) in enumerate(zip(self.bars, self.closes_cycle, strict=True))
        ]

    def as_dict(self) -> dict[str, Any]:
        """The object that ``ragdoll order --json`` prints: bars by the ids of their joints."""
        return {
            "order": self.name,
            "root": self.root,
            "bars": [[self.ids[p], self.ids[q]] for p, q in self.bars.tolist()],
            "problem": [[self.ids[p], self.ids[q]] for p, q in self.problem.tolist()],
        }


def order(
    structure: Structure | str | Path,
    order: str = "bfs_cycle",
    root: str | int | None = None,
    *,
    seed: int = 0,
) -> BarOrder:
    """The bars in the order of the first iteration.

    Args:
        structure: a structure, or its file.
        order: a name, or ``file:PATH`` of an order file.
        root: id or index of the joint to start from; the first by default.
        seed: of the random order.

    Raises:
        InputError: an unknown order or joint; a tree order on a structure with cycles; a file
            that does not fit the structure.
    """
    structure = structure_of(structure)
    if order.startswith("file:"):
        with refusals():
            bars, closes = _method_files.read_order(order.removeprefix("file:"), structure)
        return _bar_order(order, "", bars, closes, structure)
    framework = structure.framework()
    if order in TREE_ORDERS and framework.cycle_rank > 0:
        raise InputError(
            f"order {order} leaves out the bars that close cycles, and this structure has cycles; "
            "choose bfs_cycle or dfs_cycle."
        )
    with refusals():
        start = joint_of(structure, 0 if root is None else root)
        bars, closes = _core.order(framework, order, [start], seed)
    name_of_root = "" if order == "random" else structure.ids[start]
    return _bar_order(order, name_of_root, bars, closes, structure)


def _bar_order(name, root, bars, closes, structure) -> BarOrder:
    return BarOrder(
        name,
        root,
        np.asarray(bars, dtype=np.int32).reshape(-1, 2),
        np.asarray(closes, dtype=bool),
        list(structure.ids),
    )
