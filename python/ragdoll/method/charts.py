"""The thesis' charts: means, modes and deviations by technique, histograms of iterations."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402
from matplotlib.ticker import FuncFormatter, MaxNLocator  # noqa: E402

from .cells import Cell, Cells  # noqa: E402
from .histograms import draw_histograms  # noqa: E402
from .palette import colours_of, label_of  # noqa: E402
from .runs import TaskRuns  # noqa: E402

OVERVIEW = "overview.png"


@dataclass(frozen=True)
class Pictures:
    """The charts of one class."""

    class_name: str
    summary: Path  #: means, modes, deviations, failures
    histograms: Path


def draw_all(tasks: Sequence[TaskRuns], cells: Cells, folder: Path) -> list[Pictures]:
    """Draw the charts of every class, and one of all, as PNG files in a folder."""
    draw_overview(cells, folder / OVERVIEW)
    pictures = []
    for class_name in cells.classes:
        made = Pictures(
            class_name,
            folder / f"{class_name}_summary.png",
            folder / f"{class_name}_histograms.png",
        )
        of_class = cells.of_class(class_name)
        _draw_summary(class_name, of_class, made.summary)
        draw_histograms(
            class_name,
            [task for task in tasks if task.entry.class_name == class_name],
            made.histograms,
        )
        pictures.append(made)
    return pictures


def _draw_summary(class_name: str, cells: list[Cell], path: Path) -> None:
    """Four panels of bars: techniques along, weightings by colour."""
    groups = list(dict.fromkeys(label_of(c.technique) for c in cells))
    colours = colours_of(cells)
    width = max(9.0, 0.35 * len(groups) * len(colours) + 2)
    figure, axes = plt.subplots(
        4, 1, figsize=(width, 12), dpi=110, layout="constrained", sharex=True
    )
    panels = (
        ("mean of iterations", lambda s: s.mean, True),
        ("mode of iterations", lambda s: s.mode, False),
        ("standard deviation", lambda s: s.stdev, True),
        ("forces not resolved / %", lambda s: 100 * s.failed / s.forces, False),
    )
    for panel, (title, value, logarithmic) in zip(axes, panels, strict=True):
        _draw_bars(panel, cells, groups, colours, value, logarithmic)
        panel.set_ylabel(title)
    axes[0].legend(
        title="weighting, far end first",
        ncols=len(colours),
        loc="lower right",
        bbox_to_anchor=(1, 1),
        frameon=False,
    )
    axes[-1].set_xticks(range(len(groups)), groups, rotation=20 if len(groups) > 6 else 0)
    s = cells[0]
    figure.suptitle(
        f"{class_name}: {s.structures} structures, {s.statistics.forces} forces\n",
        x=0.02,
        ha="left",
        fontweight="bold",
    )
    figure.savefig(path)
    plt.close(figure)


def _draw_bars(panel, cells, groups, colours, value, logarithmic: bool) -> None:
    room = 0.84 / len(colours)
    highest = 1.0
    for place, (weighting, colour) in enumerate(colours.items()):
        chosen = [cell for cell in cells if cell.technique.weighting == weighting]
        shift = (place - (len(colours) - 1) / 2) * room
        places = [groups.index(label_of(cell.technique)) + shift for cell in chosen]
        heights = [value(cell.statistics) for cell in chosen]
        bars = panel.bar(places, heights, room * 0.92, color=colour, label=weighting)
        panel.bar_label(bars, [_short(height) for height in heights], padding=2, fontsize=7)
        highest = max(highest, *heights)
    _scale(panel, highest, logarithmic)
    panel.grid(axis="y", alpha=0.3)
    panel.set_axisbelow(True)
    panel.spines[["top", "right"]].set_visible(False)


def _scale(panel, highest: float, logarithmic: bool) -> None:
    """From 0; logarithmic above 1 where the numbers span decades."""
    if logarithmic and highest > 50:
        panel.set_yscale("symlog", linthresh=1, linscale=0.4)
        panel.set_ylim(0, highest * 3)
        panel.yaxis.set_major_formatter(FuncFormatter(lambda y, _: f"{y:g}"))
    else:
        panel.set_ylim(0, highest * 1.18 if highest > 0 else 1)
        panel.yaxis.set_major_locator(MaxNLocator(5, integer=highest > 4))


def _short(number: float) -> str:
    if number >= 9.95:
        return f"{number:.0f}"
    return f"{number:.2g}" if number else "0"


def draw_overview(cells: Cells, path: Path) -> None:
    """Means of all classes and techniques, as numbers on colours."""
    classes, techniques = cells.classes, cells.techniques
    means = np.full((len(techniques), len(classes)), np.nan)
    for cell in cells:
        place = techniques.index(cell.technique), classes.index(cell.class_name)
        means[place] = cell.statistics.mean
    figure, panel = plt.subplots(
        figsize=(2.6 + 1.5 * len(classes), 1.3 + 0.27 * len(techniques)),
        dpi=110,
        layout="constrained",
    )
    shades = np.log10(np.maximum(means, 0.5))
    panel.imshow(shades, aspect="auto", cmap="YlOrRd", vmin=0, vmax=3.4)
    for cell in cells:
        y, x = techniques.index(cell.technique), classes.index(cell.class_name)
        s = cell.statistics
        words = f"{s.mean:.3g}" if s.mean < 1000 else f"{s.mean:.0f}"
        words += f"  ✗ {s.failed}" if s.failed else ""
        least = s.mean == np.nanmin(means[:, x])
        panel.text(
            x,
            y,
            words,
            ha="center",
            va="center",
            fontsize=9,
            fontweight="bold" if least else "normal",
            color="white" if shades[y, x] > 2.3 else "black",
        )
    panel.set_xticks(range(len(classes)), classes)
    panel.set_yticks(range(len(techniques)), [t.name for t in techniques])
    panel.xaxis.tick_top()
    panel.tick_params(length=0)
    panel.spines[:].set_visible(False)
    panel.set_xlabel("bold: the lowest mean of its class\n✗: forces that were not resolved")
    figure.savefig(path)
    plt.close(figure)
