"""Hydrogens of N, O and S, put where geometry and hydrogen bonds say."""

import numpy as np
from numpy.typing import NDArray

from . import _core


def turn_polar_hydrogens(
    elements: NDArray[np.int32],
    charges: NDArray[np.int32],
    masses: NDArray[np.float64],
    positions: NDArray[np.float64],
    bonds: NDArray[np.int32],
    bond_orders: NDArray[np.uint8],
    is_new: NDArray[np.bool_],
) -> NDArray[np.float64]:
    """Move new hydrogens of N, O and S to where core's place_hydrogens has them.

    PDBFixer spreads hydrogens by repulsion alone, which leaves those of peptide bonds out of their
    plane by 20 degrees and more, so that most hydrogen bonds of a structure are lost.

    Args:
        elements, charges, masses: (N,).
        positions: (N, 3) in nm.
        bonds, bond_orders: (B, 2) and (B,).
        is_new: (N,) hydrogens that may be moved.

    Returns:
        Positions; hydrogens stay where an atom bears more or fewer than core would place on it.
    """
    heavy = elements > 1
    number = np.cumsum(heavy) - 1
    between = heavy[bonds].all(axis=1)
    bare = _core.Molecule(
        elements[heavy],
        charges[heavy],
        masses[heavy],
        np.ascontiguousarray(positions[heavy]),
        number[bonds[between]].astype(np.int32),
        bond_orders[between],
        [],
    )
    parents, places = _core.place_hydrogens(bare)
    borne: dict[int, list[int]] = {}
    for i, j in bonds.tolist():
        for hydrogen, parent in ((i, j), (j, i)):
            if elements[hydrogen] == 1:
                borne.setdefault(int(number[parent]), []).append(hydrogen)
    moved = positions.copy()
    for parent in np.unique(parents):
        hydrogens, free = borne.get(int(parent), []), places[parents == parent]
        if len(hydrogens) != len(free) or not is_new[hydrogens].all():
            continue
        for hydrogen in hydrogens:
            nearest = int(np.linalg.norm(free - positions[hydrogen], axis=1).argmin())
            moved[hydrogen] = free[nearest]
            free = np.delete(free, nearest, axis=0)
    return moved
