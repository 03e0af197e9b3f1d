"""Two atoms that a text names, by addresses or by selections."""

import warnings
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .errors import InputError

_FORM = "A:CYS145:SG=LIG:C12, or two selections 'SEL1; SEL2'"


def two_atoms(
    text: str,
    rows: Sequence[tuple[int, str, str, str, str]],
    elements: NDArray[np.int32],
    places: NDArray[np.float64],
) -> tuple[int, int]:
    """The two atoms of a bond that a user names.

    Args:
        text: ``CHAIN:RESIDUE:ATOM=CHAIN:RESIDUE:ATOM``, the chain where it is needed; a residue is
            a name, a number, or both; or two selections in MDAnalysis' language, parted by ``;``.
        rows: index, chain, residue name, residue number and name of each atom.
        elements: (N,) by index.
        places: (N, 3) by index, angstrom.

    Raises:
        InputError: the text is not of this form, or an end is no atom or several.
    """
    origin = f"--covalent-bond '{text}'"
    by_selection = ";" in text
    parts = [part.strip() for part in text.split(";" if by_selection else "=")]
    if len(parts) != 2 or not all(parts):
        raise InputError(f"{origin} must name two atoms: {_FORM}.")
    if by_selection:
        universe = _universe(rows, elements, places)
        ends = [_selected(part, universe, rows, origin) for part in parts]
    else:
        ends = [_addressed(part, rows, origin) for part in parts]
    if ends[0] == ends[1]:
        raise InputError(f"{origin} joins an atom with itself; name two.")
    return ends[0], ends[1]


def _addressed(part: str, rows: Sequence[tuple[int, str, str, str, str]], origin: str) -> int:
    fields = [field.strip() for field in part.split(":")]
    if len(fields) not in (2, 3) or not all(fields):
        raise InputError(f"{origin}: '{part}' must be RESIDUE:ATOM or CHAIN:RESIDUE:ATOM.")
    chain = fields[0] if len(fields) == 3 else None
    residue, name = fields[-2].upper(), fields[-1].upper()
    found = [
        row
        for row in rows
        if row[4].upper() == name
        and (chain is None or row[1] == chain)
        and residue in (row[2].upper(), row[3].upper(), (row[2] + row[3]).upper())
    ]
    return _only([row[0] for row in found], part, origin)


def _selected(part: str, universe, rows, origin: str) -> int:
    from MDAnalysis.exceptions import SelectionError

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            found = universe.atoms.select_atoms(part)
        except (SelectionError, ValueError, AttributeError, TypeError, RecursionError) as error:
            reason = str(error).split("\n")[0].rstrip(".")
            raise InputError(f"{origin}: '{part}' is no selection of atoms: {reason}.") from None
    return _only([rows[k][0] for k in found.indices.tolist()], part, origin)


def _only(found: list[int], part: str, origin: str) -> int:
    if not found:
        raise InputError(f"{origin}: '{part}' matches no atom.")
    if len(found) > 1:
        raise InputError(f"{origin}: '{part}' matches {len(found)} atoms; name one.")
    return found[0]


def _universe(rows, elements: NDArray[np.int32], places: NDArray[np.float64]):
    import gemmi
    import MDAnalysis

    residues: dict[tuple[str, str, str], int] = {}
    chains: dict[str, int] = {}
    of_atom, of_residue = [], []
    for _, chain, name, number, _ in rows:
        key = (chain, name, number)
        if key not in residues:
            residues[key] = len(residues)
            of_residue.append(chains.setdefault(chain, len(chains)))
        of_atom.append(residues[key])
    universe = MDAnalysis.Universe.empty(
        len(rows),
        n_residues=len(residues),
        n_segments=len(chains),
        atom_resindex=of_atom,
        residue_segindex=of_residue,
        trajectory=True,
    )
    symbols = [gemmi.Element(int(elements[row[0]])).name for row in rows]
    numbers = [key[2].strip() for key in residues]
    values = {
        "names": [row[4] for row in rows],
        "types": symbols,
        "elements": symbols,
        "ids": list(range(1, len(rows) + 1)),
        "chainIDs": [row[1] for row in rows],
        "resnames": [key[1] for key in residues],
        "resids": [
            int("".join(c for c in n if c.isdigit() or c == "-") or k + 1)
            for k, n in enumerate(numbers)
        ],
        "segids": list(chains),
    }
    for name, value in values.items():
        universe.add_TopologyAttr(name, value)
    universe.atoms.positions = places[[row[0] for row in rows]]
    return universe
