"""Bonds of an OpenMM topology and back."""

import numpy as np
from numpy.typing import NDArray
from openmm.app import Topology
from openmm.app.topology import Amide, Aromatic, Double, Single, Triple

from .residues import AROMATIC, DOUBLE, SINGLE, TRIPLE, UNKNOWN

_TYPES = {SINGLE: (Single, 1), DOUBLE: (Double, 2), TRIPLE: (Triple, 3), AROMATIC: (Aromatic, None)}
_CODES = {Single: SINGLE, Double: DOUBLE, Triple: TRIPLE, Aromatic: AROMATIC, Amide: SINGLE}


def given_bonds(topology: Topology) -> dict[tuple[int, int], int]:
    """Return the order code (0 unknown) of each bond, the smaller atom index first."""
    bonds: dict[tuple[int, int], int] = {}
    for bond in topology.bonds():
        i, j = sorted((bond[0].index, bond[1].index))
        stated = bond.order if bond.order in (SINGLE, DOUBLE, TRIPLE) else UNKNOWN
        bonds[(i, j)] = _CODES.get(bond.type, stated)
    return bonds


def add_bonds(topology: Topology, bonds: NDArray[np.int32], orders: NDArray[np.uint8]) -> None:
    """Add bonds (B, 2) with order codes (B,) to a topology."""
    atoms = list(topology.atoms())
    for (i, j), code in zip(bonds.tolist(), orders.tolist(), strict=True):
        kind, order = _TYPES.get(code, (None, None))
        topology.addBond(atoms[i], atoms[j], kind, order)
