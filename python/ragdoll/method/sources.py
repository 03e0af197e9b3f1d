"""What the functions of the method take: objects, or the files that hold them."""

import gzip
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from rdkit import Chem, rdBase

from .. import _core, _method_files
from ..errors import InputError
from ..framework import core_molecule
from ..molecule import Molecule

Structure = _core.Structure
ForceSet = _core.ForceSet


@contextmanager
def refusals() -> Iterator[None]:
    """Turn what core refuses into an InputError of one sentence, a failing disk into OSError."""
    try:
        yield
    except InputError:
        raise
    except ValueError as error:
        sentence = str(error)
        raise InputError(sentence if sentence.endswith(".") else f"{sentence}.") from None
    except RuntimeError as error:  # the disk failed
        raise OSError(str(error)) from None


def structure_of(
    source: Structure | Molecule | str | Path, warnings: list[str] | None = None, *, model: int = 1
) -> Structure:
    """A structure, or the one that a file holds, or the bond graph of a molecule.

    Args:
        source: the structure, the molecule, or the path of a file: a structure (.xml), or a
            molecule (PDB, mmCIF, SDF), of which each atom is a joint and each bond a bar.
        warnings: what the reader ignored is appended here.
        model: model of a PDB or mmCIF file, molecule of an SDF file, from 1.

    Raises:
        InputError: the file cannot be used; the message names file, line and reason.
    """
    if isinstance(source, Structure):
        return source
    if isinstance(source, (str, Path)):
        path = Path(source)
        names = [suffix.lower() for suffix in path.suffixes]
        if names[-1:] == [".xml"] or not names:
            with refusals():
                structure, ignored = _method_files.read_structure(str(path))
            _add(warnings, ignored)
            return structure
        source = _molecule_of(path, ".sdf" in names or ".mol" in names, model)
    _add(warnings, source.notes)
    with refusals():
        return _core.structure_of(core_molecule(source))


def _add(warnings: list[str] | None, sentences: Sequence[str]) -> None:
    if warnings is not None:
        warnings.extend(sentences)


def _molecule_of(path: Path, is_sdf: bool, model: int) -> Molecule:
    if not is_sdf:
        return Molecule.from_file(path, model=model)
    if not path.is_file():
        raise InputError(f"There is no file {path}.")
    quiet = rdBase.BlockLogs()
    with quiet, gzip.open(path) if path.suffix == ".gz" else open(path, "rb") as file:
        for number, mol in enumerate(Chem.ForwardSDMolSupplier(file, removeHs=False), 1):
            if number == model:
                if mol is None:
                    raise InputError(f"{path}: RDKit cannot read molecule {model}.")
                return Molecule.from_rdkit(mol)
    raise InputError(f"{path} has no molecule {model}.")


def forces_of(
    source: ForceSet | str | Path | Sequence[tuple[Any, Sequence[float]]],
    structure: Structure,
    warnings: list[str] | None = None,
) -> ForceSet:
    """A force set, the one that a file holds, or one made of (joint, (x, y, z)) pairs.

    Args:
        source: the forces; a joint is an id or an index.
        structure: what they act on.
        warnings: what the reader ignored is appended here.

    Raises:
        InputError: the file cannot be used, or a joint is not in the structure.
    """
    if isinstance(source, ForceSet):
        return source
    if isinstance(source, (str, Path)):
        with refusals():
            forces, ignored = _method_files.read_forces(str(source), structure)
        _add(warnings, ignored)
        return forces
    pairs = list(source)
    joints = np.array([joint_of(structure, joint) for joint, _ in pairs], dtype=np.int32)
    vectors = np.array([vector for _, vector in pairs], dtype=np.float64).reshape(-1, 3)
    with refusals():
        return ForceSet(joints, vectors)


def joint_of(structure: Structure, joint: str | int) -> int:
    """The index of a joint, given by its id or its index.

    Raises:
        InputError: the structure has no such joint.
    """
    count = len(structure.ids)
    if not isinstance(joint, str):
        if 0 <= int(joint) < count:
            return int(joint)
        raise InputError(f"There is no joint number {joint}; there are {count}, counted from 0.")
    try:
        return structure.ids.index(joint)
    except ValueError:
        some = ", ".join(structure.ids[:5]) + (", ..." if count > 5 else "")
        raise InputError(f"There is no joint '{joint}'; the structure has {some}.") from None


def derived_seed(seed: int, *names: str | int) -> int:
    """A seed below 2^31 that follows from another and from names, the same on every machine."""
    words = [seed & 0xFFFFFFFF]
    for name in names:
        words.extend(str(name).encode())
        words.append(256)
    return int(np.random.SeedSequence(words).generate_state(1)[0] >> 1)


def mean_bar_length(structure: Structure) -> float:
    """Mean length of the bars, in the structure's unit; 1 without bars."""
    lengths = structure.bar_lengths
    return float(np.mean(lengths)) if len(lengths) else 1.0


def force_sizes(structure: Structure, forces: ForceSet) -> np.ndarray:
    """How far each force would move its joint, |F|/m dt^2, in mean bar lengths. (F,)"""
    joints = np.asarray(forces.joints)
    strength = np.linalg.norm(np.asarray(forces.forces).reshape(-1, 3), axis=1)
    moves = strength / np.asarray(structure.masses)[joints] * forces.timestep**2
    return moves / mean_bar_length(structure)
