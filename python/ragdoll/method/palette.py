"""Colours of weightings and labels of techniques, the same in every chart."""

from .technique import Technique

_COLOURS = ("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#555555")


def label_of(technique: Technique) -> str:
    """The order, and the solver where it is another than ``ordered``."""
    if technique.solver == "ordered":
        return technique.order
    return f"{technique.order}\n{technique.solver}"


def colours_of(items) -> dict[str, str]:
    """Weightings with their colours; items are cells or runs with a technique."""
    names = list(dict.fromkeys(item.technique.weighting for item in items))
    return {name: _COLOURS[k % len(_COLOURS)] for k, name in enumerate(names)}
