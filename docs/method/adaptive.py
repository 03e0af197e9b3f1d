"""Orders that look at what is violated, against the thesis' nine.

.venv/bin/python docs/method/adaptive.py [--quick] [--json] [--publish]
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from common import (
    CLASSES,
    COLOURS,
    WEIGHTINGS,
    bootstrap,
    command_line,
    forces,
    resolve,
    structures,
    table,
)

ORDERS = (
    "random",
    "bfs_cycle",
    "dfs_cycle",
    "bfs_reverse",
    "dfs_reverse",
    "bfs_adapt",
    "bfs_random",
    "bfs_active",
    "bfs_worst",
)
OURS = ("bfs_active", "bfs_worst")
LARGE = ("random", "bfs_cycle", "bfs_adapt", "bfs_random", "bfs_worst")  # tried with large forces
FIRST_SEED = 300_000
MOST = 10_000


def measure(quick: bool) -> dict:
    usual = (12, 10) if quick else (100, 50)
    return {
        "cells": _cells(ORDERS, (0.1, 2.0), *usual),
        "large": _cells(LARGE, (2.0, 20.0), *((8, 5) if quick else (50, 20))),
    }


def _cells(orders, reach, count: int, per_structure: int) -> list[dict]:
    cells = []
    for name in CLASSES:
        drawn = [
            (structure, forces(structure, per_structure, *reach, seed))
            for seed, structure in structures(name, count, FIRST_SEED)
        ]
        for order in orders:
            for weighting in WEIGHTINGS:
                cells.append(_cell(name, order, weighting, drawn))
    return cells


def _cell(name: str, order: str, weighting: str, drawn) -> dict:
    iterations, visits, failed = [], [], 0
    for structure, pushes in drawn:
        of_structure, visited = [], []
        for k, (joint, vector, _) in enumerate(pushes):
            done = resolve(structure, joint, vector, order, weighting, seed=k, most=MOST)
            of_structure.append(done["iterations"] if done["converged"] else MOST)
            visited.append(done["bar_visits"] / structure.bar_count)
            failed += not done["converged"]
        iterations.append(np.array(of_structure))
        visits.append(np.array(visited))
    every = np.concatenate(iterations)
    return {
        "class": name,
        "order": order,
        "weighting": weighting,
        "mean": float(every.mean()),
        "interval": bootstrap(iterations, np.mean),
        "p99": int(np.percentile(every, 99, method="inverted_cdf")),
        "visits": float(np.concatenate(visits).mean()),
        "visits_interval": bootstrap(visits, np.mean),
        "failed": int(failed),
    }


def tables(found: dict) -> dict[str, str]:
    out = {
        f"adaptive {name}": table(["order", *WEIGHTINGS], _rows(found["cells"], ORDERS, name))
        for name in CLASSES
    }
    rows = [[name, *row] for name in CLASSES for row in _rows(found["large"], LARGE, name)]
    out["adaptive large"] = table(["class", "order", *WEIGHTINGS], rows)
    return out


def _rows(found: list[dict], orders, name: str) -> list[list[str]]:
    cells = {(c["class"], c["order"], c["weighting"]): c for c in found}
    rows = []
    for order in orders:
        row = [f"**{order}**" if order in OURS else order]
        for weighting in WEIGHTINGS:
            c = cells[name, order, weighting]
            low, high = c["interval"]
            fails = f", {c['failed']} fail" if c["failed"] else ""
            row.append(
                f"{c['mean']:.3g} ({low:.3g}–{high:.3g}), {c['p99']}; {c['visits']:.3g}{fails}"
            )
        rows.append(row)
    return rows


def draw(found: dict, path: Path) -> None:
    figure, axes = plt.subplots(1, 3, figsize=(12, 4.2), sharey=True, constrained_layout=True)
    for axis, name in zip(axes, CLASSES, strict=True):
        for k, order in enumerate(ORDERS):
            for weighting, marker in zip(WEIGHTINGS, "os^", strict=True):
                (c,) = (
                    c
                    for c in found["cells"]
                    if (c["class"], c["order"], c["weighting"]) == (name, order, weighting)
                )
                filled = c["failed"] == 0
                colour = COLOURS[5] if order in OURS else COLOURS[0]
                axis.plot(
                    c["visits"],
                    len(ORDERS) - k,
                    marker,
                    color=colour,
                    markerfacecolor=colour if filled else "none",
                    markersize=7,
                )
        axis.set_xscale("log")
        axis.set_title(name)
        axis.set_xlabel("visits of each bar per force")
        axis.grid(axis="y", alpha=0.3)
        axis.spines[["top", "right"]].set_visible(False)
    axes[0].set_yticks(range(len(ORDERS), 0, -1), ORDERS)
    for weighting, marker in zip(WEIGHTINGS, "os^", strict=True):
        axes[0].plot([], [], marker, color="#555555", label=weighting)
    axes[0].plot([], [], "o", color="#555555", markerfacecolor="none", label="some forces fail")
    figure.legend(frameon=False, fontsize=9, loc="outside lower center", ncols=4)
    figure.savefig(path, dpi=110)


if __name__ == "__main__":
    command_line(measure, tables, draw, "adaptive.png")
