"""How iterations, bar visits and time grow with the structure, for all classes.

.venv/bin/python docs/method/sizes.py [--quick] [--json] [--publish]
"""

import time
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from common import COLOURS, command_line, forces, table

import ragdoll
from ragdoll import _core

CLASSES = ("tree", "1-cycle", "2-cycle", "n-cycle")
OTHERS = ("grid", "cloth", "thread", "ring-chain", "regular", "protein")
TECHNIQUES = (
    ("random", ".5/.5"),
    ("bfs_cycle", ".5/.5"),
    ("bfs_cycle", ".75/.25"),
    ("bfs_cycle", "1/0"),
    ("bfs_active", ".5/.5"),
    ("bfs_worst", ".75/.25"),
)
SIZES = (100, 1_000, 10_000, 100_000)
COUNTS = {100: (20, 10), 1_000: (6, 10), 10_000: (3, 6), 100_000: (2, 4)}  # structures, forces
MOST = 1_000
FIRST_SEED = 400_000


def measure(quick: bool) -> dict:
    cells = []
    for name in (*CLASSES, *OTHERS):
        hopeless = set()
        for size in SIZES[:2] if quick else SIZES:
            count, per_structure = (2, 5) if quick else COUNTS[size]
            # an n-cycle closes one cycle for every ten joints
            cycles = size // 10 if name == "n-cycle" else 0
            drawn = []
            for seed in range(FIRST_SEED, FIRST_SEED + count):
                structure = ragdoll.generate(name, joints=size, cycles=cycles, seed=seed)
                drawn.append((structure, forces(structure, per_structure, 0.1, 2.0, seed)))
            for technique in TECHNIQUES:
                if technique in hopeless:
                    continue
                cell = _cell(drawn, *technique)
                cells.append({"class": name, "joints": size} | cell)
                if 2 * cell["failed"] >= cell["forces"]:
                    hopeless.add(technique)  # at larger sizes it would only cost time
    return {"cells": cells}


def _cell(drawn, order: str, weighting: str) -> dict:
    iterations, visits, seconds, failed = [], [], [], 0
    for structure, pushes in drawn:
        for k, (joint, vector, _) in enumerate(pushes):
            # a force of zero comes first: what follows finds a resolved structure, as in a motion
            other = (joint + 1) % structure.joint_count
            zero = np.zeros(3)
            before, _ = _timed(structure, [(other, zero)], order, weighting, k)
            took, done = _timed(structure, [(other, zero), (joint, vector)], order, weighting, k)
            seconds.append(max(took - before, 0.0))
            failed += not done["converged"][1]
            iterations.append(int(done["iterations"][1]) if done["converged"][1] else MOST)
            visits.append(int(done["bar_visits"][1]))
    return {
        "order": order,
        "weighting": weighting,
        "forces": len(iterations),
        "mean": float(np.mean(iterations)),
        "error": float(np.std(iterations) / np.sqrt(len(iterations))),
        "most": int(np.max(iterations)),
        "visits": float(np.mean(visits)),
        "milliseconds": 1e3 * float(np.median(seconds)),
        "failed": int(failed),
    }


def _timed(structure, pushes, order: str, weighting: str, seed: int) -> tuple[float, dict]:
    """Seconds, on small structures the least of two, and what became of the forces."""
    joints = np.array([joint for joint, _ in pushes], dtype=np.int32)
    vectors = np.array([vector for _, vector in pushes])
    force = _core.ForceSet(joints, vectors, max_iterations=MOST)
    seconds = []
    for _ in range(2 if structure.joint_count <= 10_000 else 1):
        start = time.perf_counter()
        done = _core.resolve_forces(structure, force, order, weighting, seed=seed)
        seconds.append(time.perf_counter() - start)
        if seconds[0] > 0.2:
            break
    return min(seconds), done


def tables(found: dict) -> dict[str, str]:
    sizes = sorted({c["joints"] for c in found["cells"]})
    by = {(c["class"], c["joints"], c["order"], c["weighting"]): c for c in found["cells"]}
    out = {}
    for title, classes in (("sizes", CLASSES), ("other classes", OTHERS)):
        rows = []
        for name in classes:
            for order, weighting in TECHNIQUES:
                row = [name, f"{order} {weighting}"]
                for size in sizes:
                    c = by.get((name, size, order, weighting))
                    if c is None:
                        row.append("–")
                        continue
                    fails = f", {c['failed']} of {c['forces']} fail" if c["failed"] else ""
                    row.append(f"{c['mean']:.3g} ± {c['error']:.2g}; {c['visits']:.3g}{fails}")
                row.append("–" if c is None else f"{c['milliseconds']:.3g}")
                rows.append(row)
        head = ["class", "technique", *(f"{size:,} joints" for size in sizes), "ms at the largest"]
        out[title] = table(head, rows)
    return out


def draw(found: dict, path: Path) -> None:
    figure, axes = plt.subplots(2, 5, figsize=(14, 6.2), sharex=True, constrained_layout=True)
    for axis, name in zip(axes.flat, (*CLASSES, *OTHERS), strict=True):
        for k, (order, weighting) in enumerate(TECHNIQUES):
            cells = [
                c
                for c in found["cells"]
                if (c["class"], c["order"], c["weighting"]) == (name, order, weighting)
            ]
            axis.loglog(
                [c["joints"] for c in cells],
                [c["visits"] for c in cells],
                "o-" if order not in ("bfs_active", "bfs_worst") else "s--",
                color=COLOURS[k],
                markersize=4,
                label=f"{order} {weighting}" if name == "tree" else None,
            )
        axis.set_title(name, fontsize=10)
        axis.set_ylim(5, 3e8)
        axis.grid(alpha=0.25)
        axis.spines[["top", "right"]].set_visible(False)
    for axis in axes[1]:
        axis.set_xlabel("joints")
    for axis in axes[:, 0]:
        axis.set_ylabel("bar visits per force")
    figure.legend(frameon=False, loc="outside lower center", ncols=6, fontsize=9)
    figure.savefig(path, dpi=110)


if __name__ == "__main__":
    command_line(measure, tables, draw, "sizes.png")
