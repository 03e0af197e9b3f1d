"""Constraints that the user sets, by atom selections in MDAnalysis' language.

A file of constraints is a JSON list; each entry is an object:

    [{"kind": "tether", "first": "resid 10 and name CA", "second": "resid 50 and name CA",
      "angstrom": 8.0},
     {"kind": "bar", "first": "index 4", "second": "index 90"},
     {"kind": "contact", "first": "segid A", "second": "resname LIG", "angstrom": 3.0},
     {"kind": "fix", "atoms": "resid 1:20"},
     {"kind": "move", "atoms": "resname LIG or byres around 8 resname LIG"}]

A tether is an upper bound, a contact a lower one, a bar a fixed distance, by default the present
one; each joins every atom of the first selection with every atom of the second. Atoms that are
fixed do not move; an entry "move" fixes all the others.
"""

import json
import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from openmm.app import Topology

from .errors import InputError
from .molecule import Molecule

_PAIR_KINDS = ("bar", "tether", "contact")
_KINDS = (*_PAIR_KINDS, "fix", "move")
_ANGSTROM = 10.0  # per nm
_LONGEST = 1e6  # angstrom
_MOST_PAIRS = 100_000  # of one entry


@dataclass(frozen=True)
class UserConstraint:
    """One entry: what holds between the atoms of two selections.

    Attributes:
        kind: "bar", "tether", "contact", "fix" or "move".
        first: a selection; of "fix" and "move" the only one.
        second: a selection.
        angstrom: the length; of a bar None is the present distance.
        origin: what messages call it.
    """

    kind: str
    first: str
    second: str = ""
    angstrom: float | None = None
    origin: str = ""

    def __post_init__(self) -> None:
        """Refuse what is incomplete."""
        name = self.origin or f"The {self.kind} constraint"
        if self.kind not in _KINDS:
            raise InputError(f"{name} has the kind '{self.kind}'; kinds are {', '.join(_KINDS)}.")
        alone = self.kind not in _PAIR_KINDS
        if not self.first.strip() or (not alone and not self.second.strip()):
            raise InputError(
                f"{name} lacks a selection; "
                + ("give one." if alone else "give two, and a length in angstrom.")
            )
        if alone and (self.second or self.angstrom is not None):
            raise InputError(f"{name} has more than one selection; atoms that are fixed need one.")
        if self.angstrom is None:
            if self.kind in ("tether", "contact"):
                raise InputError(f"{name} lacks a length; give it in angstrom.")
        elif not (math.isfinite(self.angstrom) and 0 < self.angstrom <= _LONGEST):
            raise InputError(f"{name} has the length {self.angstrom}; give a positive number.")

    @classmethod
    def parse(cls, kind: str, text: str) -> "UserConstraint":
        """From the text of a flag: ``SEL1; SEL2; LENGTH``, or ``SEL`` of atoms that are fixed, or
        that alone move.

        Raises:
            InputError: the text is no such entry.
        """
        origin = f"--{kind} '{text}'"
        if kind not in _PAIR_KINDS:
            return cls(kind, text.strip(), origin=origin)
        parts = [part.strip() for part in text.split(";")]
        if len(parts) not in (2, 3):
            raise InputError(f"{origin} must be two selections and a length: 'SEL1; SEL2; 8.0'.")
        length = None
        if len(parts) == 3:
            try:
                length = float(parts[2])
            except ValueError:
                raise InputError(
                    f"{origin} has the length '{parts[2]}'; give a number of angstrom."
                ) from None
        return cls(kind, parts[0], parts[1], length, origin)


def read_constraints(path: str | Path) -> tuple[UserConstraint, ...]:
    """The entries of a file; its format is told at the head of this module.

    Raises:
        InputError: the file cannot be read, or an entry makes no sense; the message names it.
    """
    try:
        entries = json.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror}.") from None
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path} is no JSON file: {error}.") from None
    if not isinstance(entries, list):
        raise InputError(f"{path} must be a JSON list of constraints.")
    return tuple(_entry(entry, f"{path}, entry {k + 1},") for k, entry in enumerate(entries))


def _entry(entry: Any, origin: str) -> UserConstraint:
    if not isinstance(entry, dict):
        raise InputError(f"{origin} is no object; give kind, first, second and angstrom.")
    kind = entry.get("kind")
    alone = kind in _KINDS and kind not in _PAIR_KINDS
    names = {"kind", "atoms"} if alone else {"kind", "first", "second", "angstrom"}
    unknown = entry.keys() - names
    if unknown:
        raise InputError(
            f"{origin} has '{sorted(unknown)[0]}'; a {kind} has {', '.join(sorted(names))}."
        )
    texts = [entry.get(name, "") for name in (("atoms",) if alone else ("first", "second"))]
    length = entry.get("angstrom")
    if not isinstance(kind, str) or not all(isinstance(text, str) for text in texts):
        raise InputError(f"{origin} needs texts for its kind and its selections.")
    if length is not None and (isinstance(length, bool) or not isinstance(length, int | float)):
        raise InputError(f"{origin} has the length {length!r}; give a number of angstrom.")
    return UserConstraint(
        kind, *texts, angstrom=None if length is None else float(length), origin=origin
    )


@dataclass(frozen=True)
class UserBounds:
    """What entries come to: (n, 2) int32 pairs with lengths in nm, and atoms that are fixed."""

    pairs: dict[str, tuple[NDArray[np.int32], NDArray[np.float64]]]
    fixed: list[int]


def bounds_of(molecule: Molecule, constraints: Sequence[UserConstraint]) -> UserBounds:
    """The atoms that the entries select.

    Raises:
        InputError: a selection is wrong or matches nothing; the message names the entry.
    """
    found: dict[str, dict[tuple[int, int], float]] = {kind: {} for kind in _PAIR_KINDS}
    fixed: set[int] = set()
    moving: set[int] | None = None
    select = _Selector(molecule) if constraints else None
    for entry in constraints:
        first = select(entry.first, entry)
        if entry.kind in ("fix", "move"):
            if len(first) == len(molecule):
                raise InputError(
                    f"{_name(entry)} selects all {len(first)} atoms; "
                    + ("nothing could move." if entry.kind == "fix" else "nothing would be fixed.")
                )
            if entry.kind == "fix":
                fixed.update(first.tolist())
            else:
                moving = (moving or set()) | set(first.tolist())
            continue
        second = select(entry.second, entry)
        if len(first) * len(second) > _MOST_PAIRS:
            raise InputError(
                f"{_name(entry)} joins {len(first)} with {len(second)} atoms; select fewer."
            )
        pairs = found[entry.kind]
        length = 0.0 if entry.angstrom is None else entry.angstrom / _ANGSTROM
        before = len(pairs)
        for i in first.tolist():
            for j in second.tolist():
                if i == j:
                    continue
                pair = (min(i, j), max(i, j))
                known = pairs.get(pair)
                if known is not None and entry.kind == "bar" and known != length:
                    raise InputError(
                        f"{_name(entry)} gives the bar {molecule.labels[pair[0]]} - "
                        f"{molecule.labels[pair[1]]} a second length."
                    )
                # the tighter of two bounds
                tighter = min if entry.kind == "tether" else max
                pairs[pair] = length if known is None else tighter(known, length)
        if len(pairs) == before and (len(first) == len(second) == 1) and first[0] == second[0]:
            raise InputError(f"{_name(entry)} joins an atom with itself.")
    if moving is not None:
        fixed.update(set(range(len(molecule))) - moving)
    if fixed and len(fixed) == len(molecule):
        raise InputError(f"All {len(fixed)} atoms are fixed; select fewer, so that some can move.")
    return UserBounds(
        {
            kind: (
                np.array(list(pairs), dtype=np.int32).reshape(-1, 2),
                np.array(list(pairs.values()), dtype=np.float64),
            )
            for kind, pairs in found.items()
        },
        sorted(fixed),
    )


def fixed_atoms(molecule: Molecule, constraints: Sequence[UserConstraint]) -> list[int]:
    """The atoms that the entries fix, in their order.

    Raises:
        InputError: as bounds_of does.
    """
    kept = [entry for entry in constraints if entry.kind in ("fix", "move")]
    return bounds_of(molecule, kept).fixed


def _name(entry: UserConstraint) -> str:
    return entry.origin.rstrip(",") or f"The {entry.kind} constraint"


class _Selector:
    """Selects atoms of one molecule; MDAnalysis is loaded when it is needed."""

    def __init__(self, molecule: Molecule):
        self._atoms = _universe(molecule.topology, molecule.positions, molecule.bonds).atoms

    def __call__(self, text: str, entry: UserConstraint) -> NDArray[np.int64]:
        from MDAnalysis.exceptions import SelectionError

        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                found = self._atoms.select_atoms(text)
            except (SelectionError, ValueError, AttributeError, TypeError, RecursionError) as error:
                reason = str(error).split("\n")[0].rstrip(".")
                raise InputError(
                    f"{_name(entry)}: '{text}' is no selection of atoms: {reason}."
                ) from None
        if not len(found):
            raise InputError(f"{_name(entry)}: '{text}' matches no atom.")
        return found.indices


def _universe(topology: Topology, positions: NDArray[np.float64], bonds: NDArray[np.int32]):
    import MDAnalysis

    residues = list(topology.residues())
    chains = list(topology.chains())
    atoms = list(topology.atoms())
    universe = MDAnalysis.Universe.empty(
        len(atoms),
        n_residues=len(residues),
        n_segments=len(chains),
        atom_resindex=[atom.residue.index for atom in atoms],
        residue_segindex=[residue.chain.index for residue in residues],
        trajectory=True,
    )
    values = {
        "names": [atom.name for atom in atoms],
        "types": [atom.element.symbol for atom in atoms],
        "elements": [atom.element.symbol for atom in atoms],
        "ids": list(range(1, len(atoms) + 1)),
        "chainIDs": [atom.residue.chain.id for atom in atoms],
        "resnames": [residue.name for residue in residues],
        "resids": [_number(residue) for residue in residues],
        "resnums": [_number(residue) for residue in residues],
        "icodes": [residue.insertionCode.strip() for residue in residues],
        "segids": [chain.id for chain in chains],
        "bonds": [tuple(bond) for bond in bonds.tolist()],
    }
    for name, value in values.items():
        universe.add_TopologyAttr(name, value)
    universe.atoms.positions = positions * _ANGSTROM
    return universe


def _number(residue) -> int:
    try:
        return int(residue.id)
    except ValueError:  # hybrid numbers beyond 9999, letters
        return residue.index + 1
