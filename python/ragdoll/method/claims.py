"""The thesis' claims T1 to T7, held against the cells of an experiment.

Each claim is taken word by word: a claim is a list of parts, and it holds if every part holds.
What the thesis leaves to the reader's eye is settled in LIMITS, and stands in the figures.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from .cells import Cells, View, make_cells
from .claim_parts import CHECKS, Part
from .runs import TaskRuns

TITLES = {
    "T1": "Trees: BFS_tree and DFS_tree with 1/0 always take 1 iteration; random 1/0 is near 1, "
    "not always 1.",
    "T2": "With cycles, .5/.5 has the lowest mean for every order; weighting matters more than "
    "order.",
    "T3": "BFS_cycle .5/.5 has the lowest mean of BFS_cycle, DFS_cycle and random; BFS_cycle and "
    "DFS_cycle .5/.5 do at least as well as Ragdoll.",
    "T4": "BFS_cycle 1/0: mode 1, yet by far the worst mean and standard deviation.",
    "T5": "1-cycles: DFS_cycle and random have mode 3 for every weighting, DFS_reverse mode 2, "
    "BFS_reverse mode 2 (.5/.5, .75/.25) and 1 (1/0).",
    "T6": "BFS_reverse .5/.5 is the best of all on 1- and 2-cycles: lowest mean, lowest standard "
    "deviation.",
    "T7": "BFS_adapt is worse than Ragdoll; BFS_random is like BFS_cycle.",
}

_MOST_LISTED = 4

#: under what the claims are looked at; the first is the one that decides
VIEWS = (
    View(),
    View("a reverse pass counts as two", sweeps=2),
    View("resolved forces only", resolved_only=True),
    View("forces up to 0.5 bar lengths", sizes=(0.0, 0.5)),
    View("forces of 0.5 to 1 bar lengths", sizes=(0.5, 1.0)),
    View("forces above 1 bar length", sizes=(1.0, float("inf"))),
)


@dataclass(frozen=True)
class Claim:
    """A claim of the thesis and what became of it.

    Attributes:
        name: ``T1`` to ``T7``.
        title: its words.
        holds: None where the set has nothing to try it on.
        parts: what it says, piece by piece.
        note: a sentence on where it fails, or how far it holds.
        variants: the verdict under each of VIEWS, and the parts that fail there.
    """

    name: str
    title: str
    holds: bool | None
    parts: list[Part]
    note: str
    variants: list[dict[str, Any]] = field(default_factory=list)

    def as_dict(self) -> dict[str, Any]:
        """As plain values: holds, figures by part, note, variants."""
        return {
            "claim": self.title,
            "holds": self.holds,
            "note": self.note,
            "figures": [part.as_dict() for part in self.parts],
            "variants": self.variants,
        }


def judge(tasks: Sequence[TaskRuns]) -> dict[str, Claim]:
    """All claims, under all views."""
    by_view = [(view, make_cells(tasks, view)) for view in VIEWS]
    claims = {}
    for name, check in CHECKS.items():
        variants = []
        for view, cells in by_view:
            parts = check(cells)
            variants.append(
                {
                    "view": view.name,
                    "holds": _all_hold(parts),
                    "fails": [part.statement for part in parts if part.holds is False],
                }
            )
        parts = check(by_view[0][1])
        note = _note(parts, variants)
        claims[name] = Claim(name, TITLES[name], _all_hold(parts), parts, note, variants)
    return claims


def judge_cells(cells: Cells) -> dict[str, bool | None]:
    """The verdicts on cells alone."""
    return {name: _all_hold(check(cells)) for name, check in CHECKS.items()}


def _all_hold(parts: Sequence[Part]) -> bool | None:
    verdicts = [part.holds for part in parts if part.holds is not None]
    return all(verdicts) if verdicts else None


def _note(parts: Sequence[Part], variants: Sequence[dict[str, Any]]) -> str:
    tried = [part for part in parts if part.holds is not None]
    if not tried:
        return "The set has nothing to try it on: a class, an order or a weighting is missing."
    failing = [part for part in tried if not part.holds]
    if failing:
        note = f"{len(failing)} of {len(tried)} parts fail: {_listed(failing)}"
    else:
        note = f"Every part holds: {_listed(tried)}"
    others = [v["view"] for v in variants[1:] if v["holds"] not in (None, _all_hold(parts))]
    if others:
        note += f". The verdict turns for: {', '.join(others)}"
    if len(tried) < len(parts):
        note += f". {len(parts) - len(tried)} parts could not be tried on this set"
    return note + "."


def _listed(parts: Sequence[Part]) -> str:
    """Parts with their figures; the first few stand for many."""
    words = "; ".join(f"{part.statement} ({part.words})" for part in parts[:_MOST_LISTED])
    return words + (f"; and {len(parts) - _MOST_LISTED} more" * (len(parts) > _MOST_LISTED))
