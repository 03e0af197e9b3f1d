"""What each of the thesis' claims says, piece by piece, as checks over cells.

The claims speak of the thesis' orders, weightings and classes with the ordered solver; whatever
else an experiment holds does not touch them. Ragdoll is random .5/.5.
"""

from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from .cells import Cells
from .statistics import Statistics
from .technique import THESIS_ORDERS, TREE_ORDERS, WEIGHTINGS

#: words of the thesis that name no number, and the number that stands for them here
LIMITS = {
    "by far": 2.0,  # times the next
    "like": 0.25,  # relative difference of the means
}
_CYCLES = ("1-cycle", "2-cycle", "n-cycle")
_ORDERS = tuple(order for order in THESIS_ORDERS if order not in TREE_ORDERS)
_EVEN, _UNEVEN, _FULL = WEIGHTINGS


@dataclass(frozen=True)
class Part:
    """A piece of a claim.

    Attributes:
        statement: what is claimed of which class.
        holds: None where the cells it needs are missing.
        words: the figures that decide, for people.
        figures: the same as plain values.
    """

    statement: str
    holds: bool | None
    words: str = ""
    figures: dict[str, Any] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """As plain values."""
        return asdict(self)


def _means(cells: Cells, class_name: str, orders=_ORDERS) -> dict[tuple[str, str], Statistics]:
    """Statistics of a class by order and weighting; only those that there are."""
    found = {(o, w): cells.get(class_name, o, w) for o in orders for w in WEIGHTINGS}
    return {key: statistics for key, statistics in found.items() if statistics}


def _name(key: tuple[str, str]) -> str:
    return f"{key[0]} {key[1]}"


def _figures(table: dict[tuple[str, str], Statistics], value: str) -> dict[str, float]:
    return {_name(key): getattr(statistics, value) for key, statistics in table.items()}


def t1(cells: Cells) -> Iterator[Part]:
    """Trees in one iteration."""
    for order in TREE_ORDERS:
        statement = f"tree: {order} 1/0 takes 1 iteration for every force that breaks a bar"
        s = cells.get("tree", order, _FULL)
        if s is None:
            yield Part(statement, None)
            continue
        broken = s.forces - s.nothing_broken
        # each takes at least 1: the sum tells whether each takes exactly 1
        exactly = s.failed == 0 and round(s.mean * s.forces) == broken
        words = (
            f"mean {s.mean:.4g}, mode {s.mode}, sd {s.stdev:.2g}; "
            f"{s.nothing_broken} of {s.forces} forces broke nothing and took 0"
        )
        figures = s.as_dict() | {"broken": broken}
        yield Part(statement, broken > 0 and exactly, words, figures)
    s = cells.get("tree", "random", _FULL)
    statement = "tree: random 1/0 does not always take 1 iteration"
    if s is None:
        yield Part(statement, None)
        return
    words = f"mean {s.mean:.3g}, mode {s.mode}, sd {s.stdev:.3g}; whether that is near 1, judge"
    yield Part(statement, s.stdev > 0 and s.mean != 1, words, s.as_dict())


def t2(cells: Cells) -> Iterator[Part]:
    """Even shares are best, and weighting matters more than order."""
    for class_name in _CYCLES:
        table = _means(cells, class_name)
        for order in _ORDERS:
            statement = f"{class_name}: .5/.5 has the lowest mean of {order}"
            row = {w: table[order, w].mean for w in WEIGHTINGS if (order, w) in table}
            if len(row) < 2 or _EVEN not in row:
                yield Part(statement, None)
                continue
            words = ", ".join(f"{w} {mean:.3g}" for w, mean in row.items())
            yield Part(statement, row[_EVEN] == min(row.values()), words, row)
        yield _weighting_against_order(class_name, table)


def _weighting_against_order(class_name: str, table) -> Part:
    """Compares the spread of the marginal means of weightings with that of orders."""
    statement = f"{class_name}: weighting matters more than order"
    orders = [o for o in _ORDERS if all((o, w) in table for w in WEIGHTINGS)]
    if len(orders) < 2:
        return Part(statement, None)
    means = np.array([[table[o, w].mean for w in WEIGHTINGS] for o in orders])
    of_weightings, of_orders = float(means.mean(0).std()), float(means.mean(1).std())
    words = (
        f"the means of weightings deviate by {of_weightings:.3g}, those of orders {of_orders:.3g}"
    )
    figures = {
        "deviation_of_weightings": of_weightings,
        "deviation_of_orders": of_orders,
        "by_weighting": dict(zip(WEIGHTINGS, means.mean(0).tolist(), strict=True)),
        "by_order": dict(zip(orders, means.mean(1).tolist(), strict=True)),
    }
    return Part(statement, of_weightings > of_orders, words, figures)


def t3(cells: Cells) -> Iterator[Part]:
    """BFS_cycle .5/.5 against DFS_cycle and random."""
    for class_name in _CYCLES:
        table = _means(cells, class_name, ("bfs_cycle", "dfs_cycle", "random"))
        ours, ragdoll = ("bfs_cycle", _EVEN), ("random", _EVEN)
        statement = f"{class_name}: bfs_cycle .5/.5 has the lowest mean"
        if ours not in table or len(table) < 2:
            yield Part(statement, None)
        else:
            yield _lowest(statement, table, ours, "mean")
        for order in ("bfs_cycle", "dfs_cycle"):
            statement = f"{class_name}: {order} .5/.5 does at least as well as Ragdoll"
            if (order, _EVEN) not in table or ragdoll not in table:
                yield Part(statement, None)
                continue
            mean, other = table[order, _EVEN].mean, table[ragdoll].mean
            figures = {order: mean, "ragdoll": other}
            yield Part(statement, mean <= other, f"{mean:.3g} against {other:.3g}", figures)


def _lowest(statement: str, table, ours: tuple[str, str], value: str) -> Part:
    best = min(table, key=lambda key: getattr(table[key], value))
    least, own = getattr(table[best], value), getattr(table[ours], value)
    words = f"{own:.3g}; the lowest is {_name(best)} with {least:.3g}"
    return Part(statement, own <= least, words, _figures(table, value))


def t4(cells: Cells) -> Iterator[Part]:
    """BFS_cycle 1/0 is quick as a rule and the worst at times."""
    ours = ("bfs_cycle", _FULL)
    for class_name in _CYCLES:
        table = _means(cells, class_name)
        mode = f"{class_name}: bfs_cycle 1/0 has mode 1"
        worst = f"{class_name}: bfs_cycle 1/0 has by far the worst"
        if ours not in table:
            yield from (Part(mode, None), Part(f"{worst} mean", None), Part(f"{worst} sd", None))
            continue
        s = table[ours]
        yield Part(mode, s.mode == 1, f"mode {s.mode}, {s.failed} failed", {"mode": s.mode})
        for value, word in (("mean", "mean"), ("stdev", "sd")):
            others = {key: getattr(o, value) for key, o in table.items() if key != ours}
            if not others:
                yield Part(f"{worst} {word}", None)
                continue
            next_worst = max(others, key=others.get)
            own, most = getattr(s, value), others[next_worst]
            words = f"{own:.4g}; the highest other is {_name(next_worst)} with {most:.4g}"
            figures = _figures(table, value) | {"by_far_is": LIMITS["by far"]}
            yield Part(f"{worst} {word}", own >= LIMITS["by far"] * most, words, figures)


def t5(cells: Cells) -> Iterator[Part]:
    """Modes on 1-cycles."""
    claimed = {
        "dfs_cycle": dict.fromkeys(WEIGHTINGS, 3),
        "random": dict.fromkeys(WEIGHTINGS, 3),
        "dfs_reverse": dict.fromkeys(WEIGHTINGS, 2),
        "bfs_reverse": {_EVEN: 2, _UNEVEN: 2, _FULL: 1},
    }
    for order, modes in claimed.items():
        for weighting, mode in modes.items():
            statement = f"1-cycle: {order} {weighting} has mode {mode}"
            s = cells.get("1-cycle", order, weighting)
            if s is None:
                yield Part(statement, None)
            else:
                yield Part(statement, s.mode == mode, f"mode {s.mode}", {"mode": s.mode})


def t6(cells: Cells) -> Iterator[Part]:
    """BFS_reverse .5/.5 is the best."""
    ours = ("bfs_reverse", _EVEN)
    for class_name in ("1-cycle", "2-cycle"):
        table = _means(cells, class_name)
        for value, word in (("mean", "mean"), ("stdev", "sd")):
            statement = f"{class_name}: bfs_reverse .5/.5 has the lowest {word} of all"
            if ours not in table or len(table) < 2:
                yield Part(statement, None)
            else:
                yield _lowest(statement, table, ours, value)


def t7(cells: Cells) -> Iterator[Part]:
    """BFS_adapt and BFS_random."""
    for class_name in _CYCLES:
        table = _means(cells, class_name)
        ragdoll = table.get(("random", _EVEN))
        for weighting in WEIGHTINGS:
            statement = f"{class_name}: bfs_adapt {weighting} is worse than Ragdoll"
            adapt = table.get(("bfs_adapt", weighting))
            if adapt is None or ragdoll is None:
                yield Part(statement, None)
            else:
                words = f"mean {adapt.mean:.3g} against {ragdoll.mean:.3g}"
                figures = {"bfs_adapt": adapt.mean, "ragdoll": ragdoll.mean}
                yield Part(statement, adapt.mean > ragdoll.mean, words, figures)
        for weighting in WEIGHTINGS:
            statement = f"{class_name}: bfs_random {weighting} is like bfs_cycle"
            a, b = table.get(("bfs_random", weighting)), table.get(("bfs_cycle", weighting))
            if a is None or b is None:
                yield Part(statement, None)
                continue
            like = abs(a.mean - b.mean) <= LIMITS["like"] * b.mean
            words = f"mean {a.mean:.3g} against {b.mean:.3g}"
            figures = {"bfs_random": a.mean, "bfs_cycle": b.mean, "like_is": LIMITS["like"]}
            yield Part(statement, like, words, figures)


def _listed(check: Callable[[Cells], Iterator[Part]]) -> Callable[[Cells], list[Part]]:
    return lambda cells: list(check(cells))


CHECKS: dict[str, Callable[[Cells], list[Part]]] = {
    name: _listed(check)
    for name, check in zip(
        ("T1", "T2", "T3", "T4", "T5", "T6", "T7"), (t1, t2, t3, t4, t5, t6, t7), strict=True
    )
}
