"""What the scripts beside docs/method.md share: one force at a time, tables, and their options."""

import argparse
import json
import re
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np

import ragdoll
from ragdoll import _core
from ragdoll.method.generating import generate_forces

matplotlib.use("Agg")

HERE = Path(__file__).resolve().parent
PAGE = HERE.parent / "method.md"
CLASSES = ("1-cycle", "2-cycle", "n-cycle")
WEIGHTINGS = (".5/.5", ".75/.25", "1/0")
COLOURS = ("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#555555", "#000000")


def structures(
    class_name: str, count: int, first_seed: int, joints: tuple[int, int] = (10, 50)
) -> Iterator[tuple[int, Any]]:
    """Seeds from ``first_seed`` on, and their structures; sizes are uniform, as in the thesis."""
    for seed in range(first_seed, first_seed + count):
        size = int(np.random.default_rng(seed).integers(joints[0], joints[1] + 1))
        yield seed, ragdoll.generate(class_name, joints=size, seed=seed)


def forces(structure, count: int, low: float, high: float, seed: int) -> list[tuple[int, Any, Any]]:
    """Joint, vector and size (in mean bar lengths) of forces drawn at random."""
    drawn = generate_forces(structure, count, scale_bars=(low, high), seed=seed)
    vectors = np.asarray(drawn.forces)
    masses = np.asarray(structure.masses)[drawn.joints]
    sizes = np.linalg.norm(vectors, axis=1) / masses / np.mean(structure.bar_lengths)
    return list(zip(np.asarray(drawn.joints).tolist(), vectors, sizes.tolist(), strict=True))


def resolve(structure, joint: int, vector, order: str, weighting: str, **options) -> dict[str, Any]:
    """Break a structure at rest by one force, and resolve it.

    Keywords: tolerance, most (iterations), seed.
    """
    force = _core.ForceSet(
        np.array([joint], dtype=np.int32),
        np.asarray(vector, dtype=np.float64)[None],
        max_iterations=options.get("most", 10_000),
        tolerance=options.get("tolerance", 1e-3),
    )
    done = _core.resolve_forces(structure, force, order, weighting, seed=options.get("seed", 0))
    return {
        "iterations": int(done["iterations"][0]),
        "bar_visits": int(done["bar_visits"][0]),
        "converged": bool(done["converged"][0]),
        "residual": float(done["residual"][0]),
        "positions": done["positions"],
    }


def bootstrap(per_structure: Sequence[Any], statistic: Callable, draws: int = 400, seed: int = 0):
    """95 % interval of a statistic, whole structures being drawn again and again.

    Args:
        per_structure: the values of each structure; forces on one structure are no independent
            samples.
        statistic: of the concatenated values.
    """
    random = np.random.default_rng(seed)
    values = []
    for _ in range(draws):
        chosen = random.integers(0, len(per_structure), len(per_structure))
        values.append(statistic(np.concatenate([per_structure[k] for k in chosen])))
    return tuple(np.percentile(values, [2.5, 97.5]).tolist())


def table(head: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    """A Markdown table."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    lines += ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows]
    return "\n".join(lines)


def percent(part: float, whole: float) -> str:
    """Part of a whole as text; a dash where there is nothing."""
    return f"{100 * part / whole:.3g} %" if whole else "–"


def command_line(
    measure: Callable[[bool], dict],
    tables: Callable[[dict], dict[str, str]],
    draw: Callable[[dict, Path], None] | None = None,
    picture: str = "",
) -> None:
    """Run a script: measure, print its tables; more as options say.

    Args:
        measure: takes whether it is to be quick; returns plain values.
        tables: Markdown by name, as the page has them between comments of that name.
        draw: the figure, to a path.
        picture: the figure's file name.
    """
    parser = argparse.ArgumentParser()
    parser.add_argument("--quick", action="store_true", help="a few seconds, fewer samples")
    parser.add_argument("--json", action="store_true", help="print what was measured as JSON")
    parser.add_argument("--publish", action="store_true", help="renew the page and the figure")
    options = parser.parse_args()
    start = time.perf_counter()
    found = measure(options.quick)
    if "skipped" in found:
        print(json.dumps(found) if options.json else found["skipped"])
        return
    if options.json:
        print(json.dumps(found))
        return
    texts = tables(found)
    for name, text in texts.items():
        print(f"{name}\n\n{text}\n")
    print(f"{time.perf_counter() - start:.0f} s")
    if options.publish:
        if draw:
            draw(found, HERE / picture)
        _renew(texts)


def _renew(texts: dict[str, str]) -> None:
    page = PAGE.read_text()
    for name, text in texts.items():
        mark = re.compile(rf"(<!-- {name} -->\n).*?(<!-- end -->)", re.DOTALL)
        page, count = mark.subn(lambda found, text=text: found[1] + text + "\n" + found[2], page)
        if count != 1:
            raise SystemExit(f"{PAGE} has {count} places for {name}")
    PAGE.write_text(page)
