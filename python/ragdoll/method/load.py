"""What an experiment works on: the structures and forces of a set, read once, and their hash."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .. import _core
from ..errors import InputError
from .result_set import ResultSet, SetEntry
from .runs import ForceTable
from .sources import ForceSet, Structure, derived_seed, force_sizes, forces_of, structure_of


@dataclass(frozen=True, eq=False)
class Case:
    """One structure with its force files.

    Attributes:
        entry: what results.xml says of it.
        structure: as its file has it.
        has_cycles: whether a tree order would leave bars out.
        forces: a force set for each file.
        seeds: of the random orders, for each file.
        table: the forces of all files, in order.
        hash: of the files' bytes.
    """

    entry: SetEntry
    structure: Structure
    has_cycles: bool
    forces: list[ForceSet]
    seeds: list[int]
    table: ForceTable
    hash: str


def load_case(
    results: ResultSet,
    entry: SetEntry,
    *,
    seed: int,
    tolerance: float | None,
    scale: float,
    max_iterations: int | None,
) -> Case:
    """Read one structure of a set and its force files.

    Args:
        results: the set.
        entry: which structure.
        seed: of the experiment.
        tolerance, max_iterations: in the place of the force files'.
        scale: what every force is multiplied by.

    Raises:
        InputError: a file cannot be used, or its structure is not of the class that results.xml
            says, or there are no forces.
    """
    path = results.folder / entry.structure
    structure = structure_of(path)
    digest = hashlib.sha256(path.read_bytes())
    if not entry.forces:
        raise InputError(f"{results.folder / 'results.xml'} names no force file of {path}.")
    forces, seeds = [], []
    for relative in entry.forces:
        file = results.folder / relative
        digest.update(b"\0" + relative.as_posix().encode() + b"\0" + file.read_bytes())
        forces.append(_adapted(forces_of(file, structure), tolerance, scale, max_iterations))
        seeds.append(derived_seed(seed, "orders", entry.structure.as_posix(), relative.as_posix()))
    return Case(
        entry,
        structure,
        structure.framework().cycle_rank > 0,
        forces,
        seeds,
        _table(entry, structure, forces),
        digest.hexdigest(),
    )


def _adapted(forces: ForceSet, tolerance, scale, max_iterations) -> ForceSet:
    """The same forces with other settings."""
    if tolerance is None and max_iterations is None and scale == 1:
        return forces
    return _core.ForceSet(
        np.asarray(forces.joints),
        np.asarray(forces.forces) * scale,
        max_iterations=forces.max_iterations if max_iterations is None else max_iterations,
        tolerance=forces.tolerance if tolerance is None else tolerance,
        timestep=forces.timestep,
    )


def _table(entry: SetEntry, structure: Structure, forces: Sequence[ForceSet]) -> ForceTable:
    ids = structure.ids
    files: list[str] = []
    joints: list[str] = []
    sizes, most = [np.zeros(0)], [np.zeros(0, dtype=np.int64)]
    for path, force_set in zip(entry.forces, forces, strict=True):
        count = len(force_set.joints)
        files.extend([_short(path, entry.folder)] * count)
        joints.extend(ids[joint] for joint in force_set.joints)
        sizes.append(force_sizes(structure, force_set))
        most.append(np.full(count, force_set.max_iterations, dtype=np.int64))
    return ForceTable(files, joints, np.concatenate(sizes), np.concatenate(most))


def _short(path: Path, folder: Path) -> str:
    """A force file's path from its structure's folder, where it lies there."""
    return (path.relative_to(folder) if path.is_relative_to(folder) else path).as_posix()
