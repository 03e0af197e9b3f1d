"""Which atoms are bonded, by what kind of bond, and which are charged."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from openmm.app import Topology

from .bond_finder import BondFinder
from .bond_orders import perceive_bond_orders
from .charges import standard_charges
from .residue_match import MissingAtoms, missing_atoms


@dataclass(frozen=True)
class Perception:
    """Bonds of a structure.

    Attributes:
        bonds: (B, 2) atom indices, the smaller first, sorted, each pair once.
        bond_orders: (B,) codes: 1 single, 2 double, 3 triple, 4 aromatic, 5 dative (metal).
        charges: (N,) formal charges.
        coordination: (K, 2) bonds between residues that the file records for metals.
        links: (L, 2) bonds of ligands with other residues.
        missing_atoms: heavy atoms missing by the residue templates.
        notes: sentences on what could not be told for sure.
    """

    bonds: NDArray[np.int32]
    bond_orders: NDArray[np.uint8]
    charges: NDArray[np.int32]
    coordination: NDArray[np.int32]
    links: list[tuple[int, int]]
    missing_atoms: list[MissingAtoms]
    notes: list[str]


def perceive(
    topology: Topology,
    positions: NDArray[np.float64],
    given: dict[tuple[int, int], int],
    recorded: NDArray[np.int64],
    closed: frozenset[int] = frozenset(),
) -> Perception:
    """Find the bonds and bond orders of a structure.

    Args:
        topology: chains, residues and atoms; its bonds are not looked at.
        positions: (N, 3) in angstrom.
        given: bonds known beforehand with their order codes (0 unknown), the smaller index first; a
            residue with bonds among them gets no others.
        recorded: (R, 2) bonds that a file records; those of sensible length are used where
            templates do not speak.
        closed: indices of residues that have no other bonds than those given, templates or not.

    Raises:
        InputError: a standard residue has two heavy atoms of one name.
    """
    finder = BondFinder(topology, positions, given, recorded, closed)
    finder.find()
    orders, charges = perceive_bond_orders(finder.elements, positions, finder.bonds)
    bonds = dict(sorted((finder.bonds | orders).items()))
    charges |= standard_charges(finder.residues, finder.matches, finder.elements, bonds)
    charge_array = np.zeros(len(positions), dtype=np.int32)
    for index, charge in charges.items():
        charge_array[index] = charge
    return Perception(
        np.array(list(bonds), dtype=np.int32).reshape(-1, 2),
        np.array(list(bonds.values()), dtype=np.uint8),
        charge_array,
        np.array(finder.coordination, dtype=np.int32).reshape(-1, 2),
        list(finder.links),
        missing_atoms(finder.residues, finder.matches),
        finder.notes,
    )
