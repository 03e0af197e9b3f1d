"""Structures, forces and whole sets, drawn at random from a seed."""

import shutil
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .. import _core, _method_files
from ..errors import InputError
from ..molecule import Molecule
from .classifying import classify
from .result_set import RESULTS, SetEntry, write_results
from .sources import ForceSet, Structure, derived_seed, refusals, structure_of

#: the thesis' classes
CLASSES = ("tree", "1-cycle", "2-cycle", "n-cycle")
#: |F|/m dt^2 in mean bar lengths
SCALE_BARS = (0.1, 2.0)
#: joints of the structures of a set
JOINTS = (10, 50)


def generate(
    class_name: str = "tree",
    type: str = "",
    *,
    cycles: int = 0,
    joints: int = 30,
    seed: int = 0,
) -> Structure:
    """Draw a structure.

    Args:
        class_name: ``tree``, ``1-cycle``, ``2-cycle``, ``n-cycle``, ``grid``, ``ring-chain``,
            ``regular``, ``cloth``, ``thread`` or ``protein``.
        type: of a 2-cycle: ``path``, ``shared-joint`` or ``theta``; empty: any.
        cycles: the cycle rank of an n-cycle, or the rings of a chain of rings; 0: drawn.
        joints: how many; classes with a pattern of their own come as near as they can.
        seed: decides everything that is drawn.

    Raises:
        InputError: no such class or type, or a number that makes no sense for it.
    """
    with refusals():
        return _core.generate_structure(class_name, type, cycles, joints, seed)


def generate_forces(
    structure: Structure | str | Path,
    count: int = 50,
    *,
    scale_bars: tuple[float, float] = SCALE_BARS,
    seed: int = 0,
) -> ForceSet:
    """Draw forces: a joint each, a direction uniform on the sphere.

    Args:
        structure: what they act on, or its file.
        count: how many.
        scale_bars: |F|/m dt^2 is uniform between these, in mean bar lengths.
        seed: decides everything that is drawn.

    Raises:
        InputError: a number makes no sense, or no joint can move.
    """
    low, high = scale_bars
    if not (np.isfinite(low) and np.isfinite(high) and 0 <= low <= high):
        raise InputError(f"--scale-bars must be lo:hi with 0 <= lo <= hi, not {low:g}:{high:g}.")
    if count < 1:
        raise InputError(f"--count must be 1 or more, not {count}.")
    with refusals():
        return _core.generate_forces(structure_of(structure), count, low, high, seed)


@dataclass(frozen=True)
class SetReport:
    """What generate_set wrote."""

    folder: Path
    structures: int
    force_files: int


def generate_set(
    folder: str | Path,
    *,
    classes: Sequence[str] = CLASSES,
    count: int = 20,
    forces: int = 50,
    joints: tuple[int, int] = JOINTS,
    cycles: int = 0,
    scale_bars: tuple[float, float] = SCALE_BARS,
    per_file: int = 1,
    given: Sequence[Structure | Molecule | str | Path] = (),
    seed: int = 0,
    force: bool = False,
    progress: Callable[[int, int], None] = lambda done, asked: None,
) -> SetReport:
    """Write a set as the thesis' test mode does: structures, orders and force files.

    A structure of the set depends on the seed, its class and its number alone.

    Args:
        folder: where; made if it is not there.
        classes: what to draw.
        count: structures of each class.
        forces: force files of each structure.
        joints: least and most joints; uniform between them.
        cycles: of n-cycles; 0: drawn.
        scale_bars: see generate_forces.
        per_file: forces in each file. A file starts from the structure at rest, and each force
            in it from where the one before left the joints.
        given: structures, molecules, or files of them, in the place of drawn ones.
        seed: decides everything that is drawn.
        force: replace a set that is there.
        progress: called with the structures done and asked for.

    Raises:
        InputError: an option makes no sense, or the folder is in use.
    """
    folder = Path(folder)
    classes = list(dict.fromkeys(classes))
    _check_set(folder, classes, count, forces, joints, per_file, force)
    if not given:  # what cannot be drawn is refused before anything is written
        for class_name in classes:
            generate(class_name, cycles=cycles, joints=joints[0])
    folder.mkdir(parents=True, exist_ok=True)
    (folder / RESULTS).unlink(missing_ok=True)
    asked = len(given) or count * len(classes)
    width = max(3, len(str(len(given) or count)))
    drawn = _given(given) if given else _drawn(classes, count, joints, cycles, seed)
    entries = []
    for class_name, number, structure in drawn:
        files = [
            generate_forces(
                structure,
                per_file,
                scale_bars=scale_bars,
                seed=derived_seed(seed, "forces", class_name, number, k),
            )
            for k in range(forces)
        ]
        place = folder / class_name / f"{number:0{width}d}"
        entries.append(_write_entry(folder, place, class_name, structure, files))
        progress(len(entries), asked)
    write_results(folder, entries, seed)
    return SetReport(folder, len(entries), forces * len(entries))


def _drawn(classes, count, joints, cycles, seed) -> Iterator[tuple[str, int, Structure]]:
    """Class, number and structure, one after the other."""
    for class_name in classes:
        for number in range(1, count + 1):
            words = (class_name, number)
            draw = np.random.default_rng(derived_seed(seed, "joints", *words))
            structure = generate(
                class_name,
                cycles=cycles,
                joints=int(draw.integers(joints[0], joints[1] + 1)),
                seed=derived_seed(seed, "structure", *words),
            )
            yield class_name, number, structure


def _given(sources) -> Iterator[tuple[str, int, Structure]]:
    """The same of structures that are there; each class counts for itself."""
    counts: dict[str, int] = {}
    for source in sources:
        structure = structure_of(source)
        class_name = structure.class_name or classify(structure).class_name
        counts[class_name] = counts.get(class_name, 0) + 1
        yield class_name, counts[class_name], structure


def _check_set(folder, classes, count, forces, joints, per_file, force) -> None:
    for flag, value in (("--count", count), ("--forces", forces), ("--per-file", per_file)):
        if value < 1:
            raise InputError(f"{flag} must be 1 or more, not {value}.")
    if not 1 <= joints[0] <= joints[1]:
        raise InputError(f"--joints must be lo:hi with 1 <= lo <= hi, not {joints[0]}:{joints[1]}.")
    if not classes:
        raise InputError("--classes names nothing; name at least one class.")
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder} is a file; a set is a folder.")
    if folder.is_dir() and any(folder.iterdir()) and not force:
        raise InputError(f"{folder} is not empty; give --force to write a set into it.")
    if not folder.absolute().parent.is_dir():
        raise InputError(f"The folder {folder.absolute().parent} does not exist; make it first.")


def _write_entry(folder: Path, place: Path, class_name, structure, files) -> SetEntry:
    """Write one structure's folder; only what test mode writes is replaced in it."""
    for old in ("forces", "techniques"):
        shutil.rmtree(place / old, ignore_errors=True)
    (place / "forces").mkdir(parents=True)
    entry = SetEntry(
        class_name,
        place.relative_to(folder) / "structure.xml",
        place.relative_to(folder) / "order.xml",
        [
            place.relative_to(folder) / "forces" / f"{k:0{max(2, len(str(len(files))))}d}.xml"
            for k in range(1, len(files) + 1)
        ],
    )
    with refusals():
        _method_files.write_structure(str(folder / entry.structure), structure, force=True)
        joints, problem = _core.order(structure.framework(), "bfs_cycle", [0], 0)
        _method_files.write_order(
            str(folder / entry.order),
            structure,
            joints,
            np.asarray(problem, dtype=bool),
            structure.ids[0],
            "bfs_cycle",
            force=True,
            structure_path="structure.xml",
        )
        for path, forces in zip(entry.forces, files, strict=True):
            forces.structure = "../structure.xml"
            _method_files.write_forces(str(folder / path), structure, forces, force=True)
    return entry
