"""The thesis' claims under other sizes of force, tolerances and ways to count a sweep.

.venv/bin/python docs/method/claims.py [--quick] [--json] [--publish]
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from common import COLOURS, WEIGHTINGS, command_line, forces, percent, resolve, structures, table

from ragdoll.method.cells import View, make_cells
from ragdoll.method.claim_parts import CHECKS
from ragdoll.method.result_set import SetEntry
from ragdoll.method.runs import ForceTable, TaskRuns
from ragdoll.method.technique import THESIS_ORDERS, TREE_ORDERS, Technique

CLASSES = ("tree", "1-cycle", "2-cycle", "n-cycle")
REACHES = ((0.1, 0.5), (0.1, 2.0), (2.0, 20.0))
TOLERANCES = (1e-2, 1e-3, 1e-6)
VIEWS = {
    "one": View(),
    "two": View("a reverse pass counts as two", sweeps=2),
    "resolved": View("resolved forces only", resolved_only=True),
}
MOST = 10_000
FIRST_SEED = 600_000
DRAWS = 60  # of structures, class by class
SURE = 0.95


def measure(quick: bool) -> dict:
    count, per_structure = (4, 8) if quick else (20, 50)
    drawn = {name: list(structures(name, count, FIRST_SEED)) for name in CLASSES}
    settings = []
    for reach in REACHES:
        for tolerance in TOLERANCES:
            tasks = _tasks(drawn, reach, tolerance, per_structure)
            settings.append(
                {
                    "reach": list(reach),
                    "tolerance": tolerance,
                    "claims": {
                        name: _verdicts(tasks, view, count, 8 if quick else DRAWS)
                        for name, view in VIEWS.items()
                    },
                    "cells": _cells(tasks),
                }
            )
    return {"settings": settings, "forces": count * per_structure, "structures": count}


def _tasks(drawn, reach, tolerance: float, per_structure: int) -> list[TaskRuns]:
    tasks = []
    for name, of_class in drawn.items():
        for seed, structure in of_class:
            pushes = forces(structure, per_structure, *reach, seed)
            entry = SetEntry(name, Path(name, str(seed), "structure.xml"))
            sizes = np.array([size for _, _, size in pushes])
            about = ForceTable(
                [""] * len(pushes), [""] * len(pushes), sizes, np.full(len(pushes), MOST)
            )
            for order in THESIS_ORDERS:
                if order in TREE_ORDERS and name != "tree":
                    continue
                for weighting in WEIGHTINGS:
                    done = [
                        resolve(
                            structure,
                            joint,
                            vector,
                            order,
                            weighting,
                            seed=k,
                            most=MOST,
                            tolerance=tolerance,
                        )
                        for k, (joint, vector, _) in enumerate(pushes)
                    ]
                    columns = [
                        np.array([d[key] for d in done])
                        for key in ("iterations", "bar_visits", "converged", "residual")
                    ]
                    tasks.append(TaskRuns(entry, Technique(order, weighting), about, *columns))
    return tasks


def _verdicts(tasks: list[TaskRuns], view: View, count: int, draws: int) -> dict[str, list[dict]]:
    """Each part of each claim: whether it holds, and in what share of bootstrap samples it does.

    Structures are drawn again, class by class.
    """
    groups: dict[tuple[str, int], list[TaskRuns]] = {}
    seeds = sorted({int(t.entry.structure.parts[1]) for t in tasks})
    for t in tasks:
        group = (t.entry.class_name, seeds.index(int(t.entry.structure.parts[1])))
        groups.setdefault(group, []).append(t)
    random = np.random.default_rng(1)
    sampled: dict[str, list[int]] = {}
    for _ in range(draws):
        chosen = []
        for name in CLASSES:
            for k in random.integers(0, count, count):
                chosen += groups[name, int(k)]
        cells = make_cells(chosen, view)
        for claim, check in CHECKS.items():
            holds = np.array([part.holds is True for part in check(cells)], dtype=int)
            sampled[claim] = sampled.get(claim, 0) + holds
    cells = make_cells(tasks, view)
    return {
        claim: [
            {
                "statement": part.statement,
                "holds": bool(part.holds),
                "words": part.words,
                "share": float(share / draws),
            }
            for part, share in zip(check(cells), sampled[claim], strict=True)
        ]
        for claim, check in CHECKS.items()
    }


def _cells(tasks: list[TaskRuns]) -> list[dict]:
    return [
        {
            "class": cell.class_name,
            "order": cell.technique.order,
            "weighting": cell.technique.weighting,
            "mean": cell.statistics.mean,
            "mode": cell.statistics.mode,
            "stdev": cell.statistics.stdev,
            "failed": cell.statistics.failed,
            "visits": cell.statistics.bar_visits_mean,
            "resolved_mean": cell.statistics.resolved_mean,
            "forces": cell.statistics.forces,
        }
        for cell in make_cells(tasks)
    ]


def _setting(setting: dict) -> str:
    low, high = setting["reach"]
    return f"{low:g}:{high:g}, {setting['tolerance']:.0e}".replace("e-0", "e-")


def _letter(share: float) -> str:
    return "yes" if share >= SURE else "no" if share <= 1 - SURE else "?"


def _name(cell: dict) -> str:
    return f"{cell['order']} {cell['weighting']}"


def tables(found: dict) -> dict[str, str]:
    settings = found["settings"]
    rows = []
    for claim in CHECKS:
        for view in VIEWS:
            row = [claim if view == "one" else "", view]
            for setting in settings:
                parts = setting["claims"][view][claim]
                held = sum(p["share"] >= SURE for p in parts)
                failed = sum(p["share"] <= 1 - SURE for p in parts)
                holds = all(p["holds"] for p in parts)
                word = "**holds**" if holds else "no"
                row.append(f"{word} {held}/{failed}/{len(parts) - held - failed}")
            rows.append(row)
    out = {"claims": table(["claim", "counted", *(_setting(s) for s in settings)], rows)}

    rows = []
    for claim in CHECKS:
        for k, part in enumerate(settings[0]["claims"]["one"][claim]):
            one, two = (
                [_letter(setting["claims"][view][claim][k]["share"]) for setting in settings]
                for view in ("one", "two")
            )
            cells = [a if a == b else f"{a}, {b}" for a, b in zip(one, two, strict=True)]
            rows.append([claim, part["statement"], *cells])
    head = ["", "part", *(_setting(s) for s in settings)]
    out["claims parts"] = table(head, rows)

    rows = []
    for name in CLASSES[1:]:
        for setting in settings:
            cells = {_name(c): c for c in setting["cells"] if c["class"] == name}
            best = min(cells.values(), key=lambda c: c["mean"])
            thrift = min((c for c in cells.values() if not c["failed"]), key=lambda c: c["visits"])
            reverse, cycle = cells["bfs_reverse .5/.5"], cells["bfs_cycle .5/.5"]
            full, ragdoll = cells["bfs_cycle 1/0"], cells["random .5/.5"]
            rows.append(
                [
                    name,
                    _setting(setting),
                    f"{_name(best)} {best['mean']:.3g}",
                    f"{reverse['mean']:.3g} / {2 * reverse['mean']:.3g}",
                    f"{_name(thrift)} {thrift['visits']:.3g}",
                    f"{reverse['visits']:.3g}",
                    f"{cycle['mean']:.3g}",
                    f"{ragdoll['mean']:.3g}",
                    f"{full['mode']}, {full['mean']:.3g} ± {full['stdev']:.3g}, "
                    f"{percent(full['failed'], full['forces'])} fail",
                ]
            )
    head = ["class", "force, tolerance", "lowest mean", "bfs_reverse .5/.5 as one / as two"]
    head += ["fewest bar visits, none failing", "of bfs_reverse .5/.5", "bfs_cycle .5/.5"]
    head += ["Ragdoll", "bfs_cycle 1/0: mode, mean ± sd, failures"]
    out["claims figures"] = table(head, rows)
    return out


def draw(found: dict, path: Path) -> None:
    figure, axes = plt.subplots(1, 3, figsize=(12, 4), sharex=True, constrained_layout=True)
    shown = (
        ("random", ".5/.5"),
        ("bfs_cycle", ".5/.5"),
        ("bfs_cycle", ".75/.25"),
        ("bfs_cycle", "1/0"),
        ("bfs_reverse", ".5/.5"),
        ("bfs_reverse", ".75/.25"),
    )
    for axis, name in zip(axes, CLASSES[1:], strict=True):
        for k, (order, weighting) in enumerate(shown):
            values = [
                c["visits"]
                for s in found["settings"]
                for c in s["cells"]
                if (c["class"], c["order"], c["weighting"]) == (name, order, weighting)
            ]
            axis.semilogy(
                range(len(values)),
                values,
                "o-" if order != "bfs_reverse" else "s--",
                color=COLOURS[k],
                markersize=4,
                label=f"{order} {weighting}" if name == "1-cycle" else None,
            )
        for edge in (2.5, 5.5):
            axis.axvline(edge, color="#bbbbbb", linewidth=0.8)
        axis.set_title(name)
        axis.set_xticks(
            range(len(found["settings"])),
            [_setting(s) for s in found["settings"]],
            rotation=60,
            ha="right",
            fontsize=8,
        )
        axis.spines[["top", "right"]].set_visible(False)
    axes[0].set_ylabel("bar visits per force")
    figure.legend(frameon=False, fontsize=9, loc="outside lower center", ncols=6)
    figure.savefig(path, dpi=110)


if __name__ == "__main__":
    command_line(measure, tables, draw, "claims.png")
