"""Bond orders of ligands and unknown residues.

With all hydrogens present RDKit finds the one assignment that satisfies every valence. Without them
there is only the geometry, see `geometry_orders.py`.
"""

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray
from rdkit import Chem
from rdkit.Chem import rdDetermineBonds
from rdkit.Geometry import Point3D
from rdkit.rdBase import BlockLogs

from .elements import IS_METAL
from .geometry_orders import LONGEST_DOUBLE, Neighbors, orders_from_geometry
from .residues import AROMATIC, DOUBLE, SINGLE, TRIPLE, UNKNOWN

# The search over valences grows exponentially with the number of atoms that have a choice.
_LARGEST_SEARCH = 100  # atoms
_MOST_ITERATIONS = 2000
_CHARGES = (0, 1, -1, 2, -2, 3, -3)

ORDER_OF_RDKIT = {
    Chem.BondType.SINGLE: SINGLE,
    Chem.BondType.DOUBLE: DOUBLE,
    Chem.BondType.TRIPLE: TRIPLE,
    Chem.BondType.AROMATIC: AROMATIC,
}


def perceive_bond_orders(
    elements: NDArray[np.int32],
    positions: NDArray[np.float64],
    bonds: dict[tuple[int, int], int],
) -> tuple[dict[tuple[int, int], int], dict[int, int]]:
    """Give an order to every bond whose order is unknown.

    Args:
        elements: (N,) atomic numbers.
        positions: (N, 3) in angstrom.
        bonds: all bonds with their order codes, the smaller index first.

    Returns:
        The order of each bond that had none, and the formal charges found on the way.
    """
    unknown = [pair for pair, order in bonds.items() if order == UNKNOWN]
    if not unknown:
        return {}, {}
    neighbors: Neighbors = {}
    for i, j in bonds:
        neighbors.setdefault(i, []).append(j)
        neighbors.setdefault(j, []).append(i)

    orders: dict[tuple[int, int], int] = {}
    charges: dict[int, int] = {}
    for fragment, own in _fragments(unknown):
        found = _orders_from_valence(fragment, elements, positions, neighbors)
        if found is None:
            found = orders_from_geometry(own, bonds, elements, positions, neighbors)
        orders.update({pair: found[0][pair] for pair in own})
        charges.update(found[1])
    return orders, charges


def _fragments(
    pairs: Iterable[tuple[int, int]],
) -> list[tuple[list[int], list[tuple[int, int]]]]:
    """Split bonds into connected sets: the atoms and the bonds of each."""
    adjacent: Neighbors = {}
    for i, j in pairs:
        adjacent.setdefault(i, []).append(j)
        adjacent.setdefault(j, []).append(i)
    fragments = []
    seen: set[int] = set()
    for start in adjacent:
        if start in seen:
            continue
        seen.add(start)
        fragment = [start]
        for atom in fragment:
            fresh = [other for other in adjacent[atom] if other not in seen]
            seen.update(fresh)
            fragment.extend(fresh)
        own = [(i, j) for i in fragment for j in adjacent[i] if i < j]
        fragments.append((sorted(fragment), sorted(own)))
    return fragments


def _orders_from_valence(
    fragment: list[int],
    elements: NDArray[np.int32],
    positions: NDArray[np.float64],
    neighbors: Neighbors,
) -> tuple[dict[tuple[int, int], int], dict[int, int]] | None:
    hydrogens = {j for i in fragment for j in neighbors[i] if elements[j] == 1}
    atoms = sorted(hydrogens.union(fragment))
    local = {atom: number for number, atom in enumerate(atoms)}
    closed = all(j in local for i in atoms for j in neighbors[i])
    if not closed or len(atoms) > _LARGEST_SEARCH or IS_METAL[elements[atoms]].any():
        return None
    if not _hydrogens_complete(fragment, elements, positions, neighbors):
        return None

    start = Chem.RWMol()
    conformer = Chem.Conformer(len(atoms))
    for atom in atoms:
        start.AddAtom(Chem.Atom(int(elements[atom])))
        conformer.SetAtomPosition(local[atom], Point3D(*positions[atom].tolist()))
    inside = [(i, j) for i in atoms for j in neighbors[i] if i < j]
    for i, j in inside:
        start.AddBond(local[i], local[j], Chem.BondType.SINGLE)
    start.AddConformer(conformer)
    for charge in _CHARGES:
        molecule = Chem.RWMol(start)
        try:
            with BlockLogs():
                rdDetermineBonds.DetermineBondOrders(
                    molecule, charge=charge, embedChiral=False, maxIterations=_MOST_ITERATIONS
                )
                Chem.SanitizeMol(molecule)
        except (ValueError, RuntimeError):  # no assignment with this charge, or too many to try
            continue
        if any(atom.GetNumRadicalElectrons() for atom in molecule.GetAtoms()):
            continue
        orders = {
            (i, j): ORDER_OF_RDKIT[molecule.GetBondBetweenAtoms(local[i], local[j]).GetBondType()]
            for i, j in inside
        }
        if any(
            order == DOUBLE and not _short_enough(i, j, elements, positions)
            for (i, j), order in orders.items()
        ):
            continue  # the valences fit, the geometry does not
        formal = {atom: molecule.GetAtomWithIdx(local[atom]).GetFormalCharge() for atom in atoms}
        return orders, {atom: value for atom, value in formal.items() if value}
    return None


def _short_enough(
    i: int, j: int, elements: NDArray[np.int32], positions: NDArray[np.float64]
) -> bool:
    kind = sorted((int(elements[i]), int(elements[j])))
    longest = LONGEST_DOUBLE.get((kind[0], kind[1]), 0.0)
    return float(np.linalg.norm(positions[i] - positions[j])) < longest


def _hydrogens_complete(
    fragment: list[int],
    elements: NDArray[np.int32],
    positions: NDArray[np.float64],
    neighbors: Neighbors,
) -> bool:
    """Whether every carbon has the neighbours that its geometry asks for."""
    for atom in fragment:
        if elements[atom] != 6:
            continue
        vectors = positions[neighbors[atom]] - positions[atom]
        vectors = vectors / np.linalg.norm(vectors, axis=1)[:, None]
        if len(vectors) == 1 or (
            len(vectors) == 2 and vectors[0] @ vectors[1] > math.cos(math.radians(160))
        ):
            return False
        # The directions to the neighbours of a planar centre add up to nothing; they do not where a
        # hydrogen is missing.
        if len(vectors) == 3 and np.linalg.norm(vectors.sum(axis=0)) > 0.5:
            return False
    return True
