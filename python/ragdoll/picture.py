"""A picture of a trajectory: conformations on the input, RMSD by frame, RMSF by residue."""

from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402
from matplotlib.collections import LineCollection  # noqa: E402

from .errors import InputError  # noqa: E402
from .trajectory import Trajectory, TrajectoryError  # noqa: E402
from .whole_file import whole_file  # noqa: E402

_ANGSTROM = 10.0  # per nm
_MOST_TRACES = 60


def superpose(points: np.ndarray, onto: np.ndarray) -> np.ndarray:
    """Move points (N, 3) onto others (N, 3) by the best rotation (Kabsch 1976)."""
    centre, target = points.mean(axis=0), onto.mean(axis=0)
    u, _, vt = np.linalg.svd((points - centre).T @ (onto - target))
    if np.linalg.det(u @ vt) < 0:
        u[:, -1] = -u[:, -1]
    return (points - centre) @ (u @ vt) + target


def draw(trajectory_path: str | Path, picture_path: str | Path) -> None:
    """Draw a trajectory into a PNG, which appears when it is complete.

    Raises:
        InputError: the file is no trajectory or holds no frames.
        OSError: the picture cannot be written; one sentence that names it.
    """
    try:
        trajectory = Trajectory(trajectory_path)
    except TrajectoryError as error:
        raise InputError(str(error)) from None
    with trajectory:
        frames = trajectory.positions.astype(np.float64) * _ANGSTROM
        topology = trajectory.topology
        start = trajectory.arrays.get("input_positions")
    if len(frames) == 0:
        raise InputError(f"{trajectory_path} holds no frames.")
    start = frames[0] if start is None else start * _ANGSTROM
    frames = np.array([superpose(frame, start) for frame in frames])

    trace, breaks = _trace(topology, len(start))
    figure = plt.figure(figsize=(11, 5), dpi=150, layout="constrained")
    left, right = figure.subfigures(1, 2, width_ratios=[1.15, 1])
    _draw_traces(left, start[trace], frames[:, trace], breaks)
    _draw_curves(right.subplots(2, 1), start, frames, trace, topology)
    name = Path(trajectory_path).name
    figure.suptitle(f"{name}: {len(frames)} conformations, {len(start)} atoms")
    try:
        with whole_file(Path(picture_path)) as part:
            figure.savefig(part, format="png")
    finally:
        plt.close(figure)


def _trace(topology, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Atoms to draw (CA and P where there are any), and after which of them the line breaks."""
    if topology is None:
        return np.arange(count), np.zeros(0, dtype=int)
    atoms = list(topology.atoms())
    backbone = [a for a in atoms if a.name in ("CA", "P") and len(list(a.residue.atoms())) > 1]
    if len(backbone) < 3:
        backbone = [a for a in atoms if a.element is not None and a.element.symbol != "H"] or atoms
    trace = np.array([atom.index for atom in backbone])
    breaks = [
        k
        for k in range(len(backbone) - 1)
        if backbone[k].residue.chain is not backbone[k + 1].residue.chain
    ]
    return trace, np.array(breaks, dtype=int)


def _draw_traces(figure, start: np.ndarray, frames: np.ndarray, breaks: np.ndarray) -> None:
    """The backbones in the plane of their largest extents, the input in black over them."""
    axes = figure.subplots()
    centre = start.mean(axis=0)
    plane = np.linalg.svd(start - centre, full_matrices=False)[2][:2].T
    chosen = np.unique(np.linspace(0, len(frames) - 1, _MOST_TRACES).astype(int))
    colours = plt.get_cmap("viridis")(np.linspace(0, 1, len(chosen)))
    for colour, frame in zip(colours, frames[chosen], strict=True):
        for line in np.split((frame - centre) @ plane, breaks + 1):
            axes.plot(*_smooth(line).T, color=colour, linewidth=0.8, alpha=0.5)
    lines = [_smooth(line) for line in np.split((start - centre) @ plane, breaks + 1)]
    axes.add_collection(LineCollection(lines, colors="black", linewidths=1.8))
    axes.set_aspect("equal")
    axes.set_xlabel("Å")
    axes.set_ylabel("Å")
    axes.set_title("black: input; violet to yellow: first to last frame", fontsize=9)


def _smooth(points: np.ndarray, steps: int = 8) -> np.ndarray:
    """A Catmull-Rom curve through points (n, 2), for the eye."""
    if len(points) < 3:
        return points
    p = np.concatenate([points[:1], points, points[-1:]])
    a, b, c, d = p[:-3, None], p[1:-2, None], p[2:-1, None], p[3:, None]
    t = np.arange(steps)[None, :, None] / steps
    curve = b + t / 2 * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)))
    return np.concatenate([curve.reshape(-1, 2), points[-1:]])


def _draw_curves(axes, start, frames, trace, topology) -> None:
    rmsd = np.sqrt(((frames - start) ** 2).sum(axis=2).mean(axis=1))
    axes[0].plot(np.arange(1, len(rmsd) + 1), rmsd, color="tab:blue")
    axes[0].set_xlabel("frame")
    axes[0].set_ylabel("RMSD from the input / Å")
    axes[0].set_ylim(bottom=0)
    fluctuation = frames[:, trace] - frames[:, trace].mean(axis=0)
    rmsf = np.sqrt((fluctuation**2).sum(axis=2).mean(axis=0))
    axes[1].plot(np.arange(1, len(rmsf) + 1), rmsf, color="tab:orange")
    axes[1].set_xlabel("residue, counted along the chains" if topology is not None else "joint")
    axes[1].set_ylabel("RMSF / Å")
    axes[1].set_ylim(bottom=0)
