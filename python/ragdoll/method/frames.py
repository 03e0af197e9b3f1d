"""Frames of a structure into a trajectory file."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..trajectory import TrajectoryWriter, joints_topology_json
from .sources import Structure

_OBSERVABLES = {"iterations": int, "bar_visits": int, "residual": float, "converged": int}


def write_frames(
    path: Path,
    structure: Structure,
    frames: Sequence[np.ndarray],
    observables: Mapping[str, Sequence[float]],
    parameters: Mapping[str, Any],
    *,
    timestep: float = 1.0,
    force: bool = False,
) -> None:
    """Write the positions after each force.

    Args:
        path: the file, HDF5. Lengths are in the structure's unit, whatever other programs take
            them for; the attribute ``length_unit`` names it.
        structure: whose frames they are.
        frames: F times (N, 3).
        observables: iterations, bar_visits, residual and converged. (F,) each
        parameters: facts that JSON can hold.
        timestep: from one frame to the next.
        force: replace an existing file.

    Raises:
        TrajectoryUsageError: the file is there, or cannot be written.
        TrajectoryError: the disk takes no more.
    """
    bars = np.asarray(structure.bars, dtype=np.int32).reshape(-1, 2)
    with TrajectoryWriter(
        path,
        joints_topology_json(structure.ids, bars.tolist()),
        observables=_OBSERVABLES,
        parameters=parameters,
        attributes={"length_unit": structure.length_unit},
        arrays={"input_positions": np.asarray(structure.positions)},
        framework={"bars": bars, "bar_lengths": np.asarray(structure.bar_lengths)},
        force=force,
    ) as writer:
        for k, positions in enumerate(frames):
            values = {name: observables[name][k] for name in _OBSERVABLES}
            writer.append(positions, timestep * (k + 1), k + 1, values)
