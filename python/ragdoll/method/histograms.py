"""Histograms of iterations, a panel for each order."""

from collections.abc import Sequence
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

from .palette import colours_of, label_of  # noqa: E402
from .runs import TaskRuns  # noqa: E402

_COLUMNS = 3
_MOST_BINS = 40
_GAP = 1.5  # between the last bin and the bars for more, and for unresolved forces; in bins


def draw_histograms(class_name: str, tasks: Sequence[TaskRuns], path: Path) -> None:
    """The share of forces by iterations; apart from them those that take more than the axis
    shows, and those that were not resolved."""
    groups = list(dict.fromkeys(label_of(task.technique) for task in tasks))
    colours = colours_of(tasks)
    width, bins = _bins(tasks)
    rows = -(-len(groups) // _COLUMNS)
    figure, axes = plt.subplots(
        rows,
        _COLUMNS,
        figsize=(13, 2.5 * rows + 1.1),
        dpi=110,
        layout="constrained",
        sharey=True,
        squeeze=False,
    )
    for panel, group in zip(axes.flat, groups, strict=False):
        of_group = [task for task in tasks if label_of(task.technique) == group]
        for place, (weighting, colour) in enumerate(colours.items()):
            chosen = [task for task in of_group if task.technique.weighting == weighting]
            if chosen:
                offset = (place + 0.5) / len(colours) - 0.5
                _draw_one(panel, chosen, width, bins, offset, len(colours), colour)
        _label_axis(panel, width, bins)
        panel.set_title(group.replace("\n", ", "), fontsize=10)
    for panel in list(axes.flat)[len(groups) :]:
        panel.set_visible(False)
    patches = [plt.Line2D([], [], color=colour, linewidth=3) for colour in colours.values()]
    figure.legend(
        patches,
        list(colours),
        title="weighting",
        loc="outside upper right",
        ncols=len(colours),
        frameon=False,
    )
    figure.suptitle(
        f"{class_name}: how many iterations a force takes", x=0.02, ha="left", fontweight="bold"
    )
    figure.supxlabel("iterations (>: more than that; ✗: not resolved)", fontsize=10)
    figure.supylabel("share of forces / %", fontsize=10)
    figure.savefig(path)
    plt.close(figure)


def _bins(tasks: Sequence[TaskRuns]) -> tuple[int, int]:
    """Width and number of bins, so that nine of ten resolved forces are in one."""
    numbers = np.concatenate([task.iterations[task.converged] for task in tasks])
    top = int(np.percentile(numbers, 90)) + 1 if len(numbers) else 10
    top = max(top, 6)
    width = -(-(top + 1) // _MOST_BINS)
    return width, -(-(top + 1) // width)


def _draw_one(panel, tasks, width: int, bins: int, offset: float, count: int, colour) -> None:
    iterations = np.concatenate([task.iterations for task in tasks])
    converged = np.concatenate([task.converged for task in tasks])
    share = 100 / max(len(iterations), 1)
    resolved = iterations[converged] // width
    heights = np.bincount(resolved[resolved < bins], minlength=bins) * share
    panel.stairs(heights, np.arange(bins + 1), color=colour, linewidth=1.6)
    for place, number in (
        (bins + _GAP, np.count_nonzero(resolved >= bins)),
        (bins + 2 * _GAP + bins / 12, np.count_nonzero(~converged)),
    ):
        bar = bins / 12 / count
        panel.bar(place + bins / 24 + offset * bins / 12, number * share, bar, color=colour)


def _label_axis(panel, width: int, bins: int) -> None:
    step = next((n for n in (1, 2, 5, 10, 20, 50, 100) if bins * width / n <= 11), 500)
    values = np.arange(0, bins * width, step)
    places = (values + 0.5) / width  # the middle of the number
    names = [str(value) for value in values]
    more = bins + _GAP + bins / 24
    failed = bins + 2 * _GAP + bins / 12 + bins / 24
    panel.set_xticks([*places, more, failed], [*names, f">{bins * width - 1}", "✗"])
    panel.tick_params(labelsize=8, labelleft=True)
    panel.axvline(bins + _GAP / 2, color="#999999", linewidth=0.8, linestyle=":")
    panel.grid(axis="y", alpha=0.25)
    panel.set_axisbelow(True)
    panel.spines[["top", "right"]].set_visible(False)
