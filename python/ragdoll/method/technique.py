"""Techniques: an order, a weighting and a solver."""

from collections.abc import Sequence
from dataclasses import dataclass

from .. import _core
from ..errors import InputError
from .sources import refusals

#: the thesis' orders; core may know more
THESIS_ORDERS = (
    "random",
    "bfs_tree",
    "dfs_tree",
    "bfs_cycle",
    "dfs_cycle",
    "bfs_reverse",
    "dfs_reverse",
    "bfs_adapt",
    "bfs_random",
)
TREE_ORDERS = ("bfs_tree", "dfs_tree")
REVERSE_ORDERS = ("bfs_reverse", "dfs_reverse")
WEIGHTINGS = (".5/.5", ".75/.25", "1/0")


@dataclass(frozen=True, order=True)
class Technique:
    """How forces are resolved; the names are those of the command line."""

    order: str
    weighting: str
    solver: str = "ordered"

    @property
    def folder(self) -> str:
        """Name of its folder in a set: ``bfs_cycle_.5-.5``; a slash cannot be in a name."""
        name = f"{self.order}_{self.weighting.replace('/', '-')}"
        return name if self.solver == "ordered" else f"{name}_{self.solver}"

    @property
    def name(self) -> str:
        """For people: ``bfs_cycle .5/.5``."""
        name = f"{self.order} {self.weighting}"
        return name if self.solver == "ordered" else f"{name} {self.solver}"


def order_names() -> list[str]:
    """All orders, the thesis' first."""
    known = getattr(_core, "order_names", lambda: list(THESIS_ORDERS))()
    return list(THESIS_ORDERS) + [name for name in known if name not in THESIS_ORDERS]


def check_technique(order: str, weighting: str, solver: str) -> Technique:
    """The technique, its weighting in its shortest form.

    Raises:
        InputError: a name is not known, or the shares do not add up to 1.
    """
    with refusals():
        _core.check_order(order)
        weighting = _core.check_weighting(weighting)
    if solver not in _core.solver_names():
        known = ", ".join(_core.solver_names())
        raise InputError(f"solver '{solver}' is not known; choose one of: {known}.")
    return Technique(order, weighting, solver)


def all_techniques(
    orders: Sequence[str] | None = None,
    weightings: Sequence[str] | None = None,
    solvers: Sequence[str] | None = None,
) -> list[Technique]:
    """Orders x weightings x solvers, each once, in the order given.

    Args:
        orders: names; all that core knows by default.
        weightings: ``.5/.5``, ``.75/.25`` and ``1/0`` by default.
        solvers: ``ordered`` by default.

    Raises:
        InputError: a name is not known, or a list is empty.
    """
    orders = order_names() if orders is None else orders
    weightings = WEIGHTINGS if weightings is None else weightings
    solvers = ("ordered",) if solvers is None else solvers
    for flag, names in (("orders", orders), ("weightings", weightings), ("solvers", solvers)):
        if not names:
            raise InputError(f"--{flag} names nothing; name at least one.")
    techniques = [
        check_technique(order, weighting, solver)
        for solver in solvers
        for order in orders
        for weighting in weightings
    ]
    return list(dict.fromkeys(techniques))
