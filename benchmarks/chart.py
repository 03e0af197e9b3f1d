"""Time against size, as a picture."""

from pathlib import Path

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt

from programs import Records
from rows import select

# ours in warm colours and filled marks, baselines in greys and open ones
STYLES = {
    "plain": ("R: random order, every bar", "0.35", "o"),
    "plain lean": ("R, broken bars only", "0.6", "s"),
    "coloured": ("coloured sweep", "0.45", "^"),
    "openmm": ("OpenMM's CCMA, bonds only", "tab:blue", "v"),
    "ordered": ("ordered", "tab:olive", "o"),
    "newton": ("newton", "tab:red", "s"),
    "newton ensemble": ("newton in lanes, each conformer", "tab:orange", "D"),
    "ordered, bonds": ("ordered, bonds only", "tab:green", "o"),
    "ordered in lanes, bonds": ("ordered in lanes, bonds only, each", "tab:cyan", "D"),
    "block": ("block", "tab:red", "s"),
}
BASELINES = ("plain", "plain lean", "coloured", "openmm")


def line(axes, contender: str, points: list[tuple[float, float]]) -> None:
    if not points:
        return
    label, colour, mark = STYLES[contender]
    filled = "white" if contender in BASELINES else colour
    x, y = zip(*sorted(points), strict=True)
    style = "--" if contender in BASELINES else "-"
    axes.plot(x, y, style, color=colour, marker=mark, markerfacecolor=filled, label=label)


def draw(records: Records, path: Path) -> None:
    """Left: every joint displaced; right: one joint forced."""
    figure, (all_moved, one_forced) = plt.subplots(1, 2, figsize=(11, 4.6), layout="constrained")
    sizes = [
        case
        for case in select(records, "network", network="molecule", tolerance=1e-2)
        if "molecule" not in case and case["converged"] == case["breaks"]
    ]
    for contender in ("plain", "plain lean", "coloured", "ordered", "newton", "newton ensemble"):
        line(
            all_moved,
            contender,
            [(case["joints"], case["ms"]) for case in sizes if case["contender"] == contender],
        )
    rivals = select(records, "openmm", molecule="peptide", converged=True)
    line(all_moved, "openmm", [(case["joints"], case["ms"]) for case in rivals])
    bonds = [c for c in select(records, "network", network="bonds") if "molecule" not in c]
    for contender, key in (
        ("ordered", "ordered, bonds"),
        ("ordered ensemble single", "ordered in lanes, bonds"),
    ):
        cases = [case for case in bonds if case["contender"] == contender]
        line(all_moved, key, [(case["joints"], case["ms"]) for case in cases])
    all_moved.set_title("A peptide's bonds, 1-3, planar units; all joints moved, to 0.01 Å")
    all_moved.set_ylabel("ms a conformer")
    for contender in ("plain", "block"):
        cases = select(records, "forced", contender=contender)
        line(one_forced, contender, [(case["joints"], case["us"]) for case in cases])
    one_forced.set_title("A peptide's bonds; one joint forced, to 1 %")
    one_forced.set_ylabel("µs a force")
    for axes in (all_moved, one_forced):
        axes.set(xscale="log", yscale="log", xlabel="joints")
        axes.grid(alpha=0.3)
        if axes.lines:
            axes.legend(fontsize=8)
        axes.title.set_fontsize(10)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=120)
    plt.close(figure)
