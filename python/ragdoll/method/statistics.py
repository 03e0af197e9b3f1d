"""Mean, mode, deviation and percentiles of iterations, over one force file or a whole set."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from .. import _core


@dataclass(frozen=True)
class Statistics:
    """Of iterations over forces; an unresolved force counts as its maximum of iterations.

    Attributes:
        forces: how many.
        mean: None without forces, as the others.
        mode: the most frequent number of iterations; the smallest of them on ties.
        stdev: of the population (divided by the number of forces).
        p50, p99: percentiles by nearest rank, so that each is a number that occurs.
        failed: forces that were not resolved.
        bar_visits_mean: bars visited per force, those of unresolved forces as they were made.
        nothing_broken: forces that broke nothing: 0 iterations.
        resolved_mean, resolved_mode, resolved_stdev: the same over the resolved forces only.
    """

    forces: int
    mean: float | None
    mode: int | None
    stdev: float | None
    p50: int | None
    p99: int | None
    failed: int
    bar_visits_mean: float | None
    nothing_broken: int
    resolved_mean: float | None
    resolved_mode: int | None
    resolved_stdev: float | None

    def as_dict(self) -> dict[str, Any]:
        """As plain values."""
        return asdict(self)


def counted_iterations(iterations, converged, max_iterations) -> np.ndarray:
    """Iterations with the maximum in the place of unresolved forces. (F,) int64"""
    return np.where(np.asarray(converged, dtype=bool), iterations, max_iterations).astype(np.int64)


def statistics_of(counted, converged, bar_visits) -> Statistics:
    """Statistics of forces.

    Args:
        counted: iterations, unresolved forces at their maximum. (F,)
        converged: whether each force was resolved. (F,)
        bar_visits: bars visited for each force. (F,)
    """
    counted = np.asarray(counted, dtype=np.int64)
    converged = np.asarray(converged, dtype=bool)
    every, resolved = _of(counted), _of(counted[converged])
    return Statistics(
        forces=len(counted),
        mean=every["mean"],
        mode=every["mode"],
        stdev=every["stdev"],
        p50=every["p50"],
        p99=every["p99"],
        failed=int(np.count_nonzero(~converged)),
        bar_visits_mean=float(np.mean(bar_visits)) if len(counted) else None,
        nothing_broken=int(np.count_nonzero(counted == 0)),
        resolved_mean=resolved["mean"],
        resolved_mode=resolved["mode"],
        resolved_stdev=resolved["stdev"],
    )


def _of(values: np.ndarray) -> dict[str, Any]:
    if len(values) == 0:
        return dict.fromkeys(("mean", "mode", "stdev", "p50", "p99"))
    return _core.statistics(np.ascontiguousarray(values))
