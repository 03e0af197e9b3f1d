"""Bond orders from bond lengths and angles alone, for molecules without all their hydrogens.

A wrong double bond freezes a rotation, a wrong single bond only loosens one: in doubt a bond is
single. All lengths are in angstrom.
"""

import numpy as np
from numpy.typing import NDArray
from rdkit import Chem

from .residues import AROMATIC, DOUBLE, SINGLE, TRIPLE, UNKNOWN

Neighbors = dict[int, list[int]]
Orders = dict[tuple[int, int], int]

H, C, N, O, P, S, SE = 1, 6, 7, 8, 15, 16, 34  # noqa: E741

# Usual bond lengths in aromatic rings, how far one bond may lie from them, and how far above them
# the mean of a ring may. Crystal structures of complexes are no more exact than that; flatness
# tells more than lengths.
_AROMATIC_LENGTHS = {
    (C, C): 1.40, (C, N): 1.34, (N, N): 1.33, (C, O): 1.37, (C, S): 1.72, (N, O): 1.39,
    (N, S): 1.65, (C, SE): 1.87,
}  # fmt: skip
_AROMATIC_SPREAD = 0.13
_AROMATIC_MEAN = 0.05
_RING_FLATNESS = 0.1
_CENTER_FLATNESS = 0.15  # a tetrahedral centre lies 0.4 or more above the plane of three neighbours
# Longest double bonds to an atom at the end, and inside a chain.
_TERMINAL_DOUBLE = {(C, O): 1.29, (C, S): 1.70, (O, S): 1.55, (O, P): 1.56, (N, O): 1.30}
_INNER_DOUBLE = {(C, C): 1.39, (C, N): 1.32, (N, N): 1.31}
_AMIDINE_DOUBLE = 1.38
_METHINE_BRIDGE = 1.43
# No double bond is longer, conjugated ones and poor coordinates included.
LONGEST_DOUBLE = {
    (C, C): 1.45, (C, N): 1.39, (C, O): 1.32, (N, N): 1.36, (N, O): 1.33, (C, S): 1.74,
    (O, S): 1.60, (O, P): 1.60, (N, S): 1.62, (N, P): 1.62,
}  # fmt: skip
_TRIPLE = {(C, C): 1.26, (C, N): 1.22}
_CUMULATED = {(C, C): 1.35, (C, N): 1.28, (C, O): 1.26, (N, N): 1.30}


def orders_from_geometry(
    unknown: list[tuple[int, int]],
    bonds: Orders,
    elements: NDArray[np.int32],
    positions: NDArray[np.float64],
    neighbors: Neighbors,
) -> tuple[Orders, dict[int, int]]:
    """Give orders to one connected set of bonds.

    Args:
        unknown: the bonds to be given an order.
        bonds: all bonds of the structure with their order codes.
        elements: (N,) atomic numbers.
        positions: (N, 3) in angstrom.
        neighbors: bonded atoms of each atom.

    Returns:
        The order of each bond of `unknown`, and the formal charges that the orders imply.
    """
    fragment = _Fragment(unknown, bonds, elements, positions, neighbors)
    fragment.mark_aromatic_rings()
    fragment.mark_linear()
    fragment.mark_terminal()
    fragment.mark_amidines()
    fragment.mark_inner()
    fragment.mark_methine_bridges()
    orders = {pair: order or SINGLE for pair, order in fragment.orders.items()}
    return orders, fragment.charges()


class _Fragment:
    def __init__(
        self,
        unknown: list[tuple[int, int]],
        bonds: Orders,
        elements: NDArray[np.int32],
        positions: NDArray[np.float64],
        neighbors: Neighbors,
    ) -> None:
        self.orders: Orders = dict.fromkeys(unknown, UNKNOWN)
        self.atoms = sorted({atom for pair in unknown for atom in pair})
        self.element = {atom: int(elements[atom]) for atom in self.atoms}
        self.positions = positions
        # A dative bond to a metal leaves a nitrogen as flat and as unsaturated as it was.
        self.neighbors = {
            i: [j for j in neighbors[i] if bonds[(min(i, j), max(i, j))] != 5] for i in self.atoms
        }
        self.hydrogens = {
            i: sum(int(elements[j]) == H for j in self.neighbors[i]) for i in self.atoms
        }
        self.saturated: set[int] = set()  # atoms that have their double or aromatic bond
        self.planar = {i: self._is_planar(i) for i in self.atoms}
        self.rings = self._find_rings()

    def length(self, i: int, j: int) -> float:
        return float(np.linalg.norm(self.positions[i] - self.positions[j]))

    def kind(self, i: int, j: int) -> tuple[int, int]:
        pair = self.element[i], self.element[j]
        return (min(pair), max(pair))

    def set_order(self, i: int, j: int, order: int) -> None:
        self.orders[(min(i, j), max(i, j))] = order
        self.saturated |= {i, j}

    def partners(self, i: int) -> list[int]:
        """Neighbours of `i` over bonds whose order is still open."""
        return [j for j in self.neighbors[i] if self.orders.get((min(i, j), max(i, j))) == UNKNOWN]

    def ends(self, i: int) -> list[int]:
        """Open neighbours of `i` that have no other neighbour, the nearest first."""
        return sorted(
            (j for j in self.partners(i) if len(self.neighbors[j]) == 1),
            key=lambda j: self.length(i, j),
        )

    def cosine(self, i: int) -> float:
        a, b = self.positions[self.neighbors[i]] - self.positions[i]
        return float(a @ b / (np.linalg.norm(a) * np.linalg.norm(b)))

    def _is_planar(self, i: int) -> bool:
        around = self.neighbors[i]
        if len(around) == 2:
            return self.cosine(i) < np.cos(np.radians(115))
        if len(around) == 3:
            a, b, c = self.positions[around] - self.positions[i]
            normal = np.cross(b - a, c - a)
            return bool(abs(a @ normal) < _CENTER_FLATNESS * np.linalg.norm(normal))
        return len(around) == 1

    def _is_linear(self, i: int) -> bool:
        return len(self.neighbors[i]) == 2 and self.cosine(i) < np.cos(np.radians(160))

    def _find_rings(self) -> list[list[int]]:
        local = {atom: number for number, atom in enumerate(self.atoms)}
        molecule = Chem.RWMol()
        for _ in self.atoms:
            molecule.AddAtom(Chem.Atom(0))
        for i, j in self.orders:
            molecule.AddBond(local[i], local[j], Chem.BondType.SINGLE)
        return [[self.atoms[k] for k in ring] for ring in Chem.GetSymmSSSR(molecule)]

    def mark_aromatic_rings(self) -> None:
        for ring in self.rings:
            sides = list(zip(ring, ring[1:] + ring[:1], strict=True))
            if len(ring) not in (5, 6) or not all(self._may_be_aromatic(i) for i in ring):
                continue
            excess = [
                self.length(i, j) - _AROMATIC_LENGTHS.get(self.kind(i, j), 0.0) for i, j in sides
            ]
            if max(map(abs, excess)) > _AROMATIC_SPREAD or sum(excess) / len(ring) > _AROMATIC_MEAN:
                continue
            centered = self.positions[ring] - self.positions[ring].mean(axis=0)
            normal = np.linalg.svd(centered)[2][2]
            if np.abs(centered @ normal).max() < _RING_FLATNESS:
                for i, j in sides:
                    self.set_order(i, j, AROMATIC)

    def _may_be_aromatic(self, i: int) -> bool:
        return len(self.neighbors[i]) == 2 or (len(self.neighbors[i]) == 3 and self.planar[i])

    def mark_linear(self) -> None:
        for i in self.atoms:
            if self.element[i] not in (C, N) or not self._is_linear(i):
                continue
            around = sorted(self.partners(i), key=lambda j: self.length(i, j))
            for j in around:
                end = self._is_linear(j) or len(self.neighbors[j]) == 1
                short = self.length(i, j) < _TRIPLE.get(self.kind(i, j), 0.0)
                if end and short and i not in self.saturated:
                    self.set_order(i, j, TRIPLE)
            if i not in self.saturated and all(
                self.length(i, j) < _CUMULATED.get(self.kind(i, j), 0.0) for j in around
            ):
                for j in around:
                    self.set_order(i, j, DOUBLE)

    def mark_terminal(self) -> None:
        for i in self.atoms:
            element, around = self.element[i], len(self.neighbors[i])
            room = 0
            if element == C and self.planar[i] and i not in self.saturated:
                room = 1
            elif element == C and self.planar[i] and around == 3:
                room = 1  # the carbonyl of a flat ring such as uracil's
            elif element == N and around == 3 and self.planar[i] and len(self.ends(i)) >= 2:
                room = 1  # nitro
            elif element == P and around == 4:
                room = 1
            elif element in (S, SE):
                room = {3: 1, 4: 2}.get(around, 0)
            for j in self.ends(i)[:room]:
                if self.element[j] in (O, S) and self.length(i, j) < _TERMINAL_DOUBLE.get(
                    self.kind(i, j), 0.0
                ):
                    self.set_order(i, j, DOUBLE)

    def mark_amidines(self) -> None:
        for i in self.atoms:
            nitrogens = [j for j in self.neighbors[i] if self.element.get(j) == N]
            if (
                self.element[i] != C
                or len(nitrogens) < 2
                or i in self.saturated
                or not self.planar[i]
            ):
                continue
            if len(self.neighbors[i]) != 3:
                continue
            free = [
                j
                for j in self.partners(i)
                if j in nitrogens and j not in self.saturated and self.planar[j]
            ]
            free = [j for j in free if self.length(i, j) < _AMIDINE_DOUBLE]
            if free:
                # A nitrogen at the end is the likelier one; else the shortest bond.
                heavy = {j: len(self.neighbors[j]) - self.hydrogens[j] for j in free}
                self.set_order(i, min(free, key=lambda j: (heavy[j], self.length(i, j))), DOUBLE)

    def mark_inner(self) -> None:
        for i, j in sorted(self.orders, key=lambda pair: self.length(*pair)):
            if self.orders[(i, j)] != UNKNOWN or {i, j} & self.saturated:
                continue
            short = self.length(i, j) < _INNER_DOUBLE.get(self.kind(i, j), 0.0)
            if short and self._may_be_double(i) and self._may_be_double(j):
                self.set_order(i, j, DOUBLE)

    def _may_be_double(self, i: int) -> bool:
        limit = 3 if self.element[i] == C else 2
        return self.planar[i] and len(self.neighbors[i]) <= limit

    def mark_methine_bridges(self) -> None:
        """The carbons between the rings of a porphyrin belong to its aromatic system."""
        ring_bonds = {
            (min(p), max(p))
            for ring in self.rings
            for p in zip(ring, ring[1:] + ring[:1], strict=True)
        }
        for i in self.atoms:
            if self.element[i] != C or i in self.saturated or not self.planar[i]:
                continue
            flat = [
                j
                for j in self.partners(i)
                if j in self.saturated
                and (min(i, j), max(i, j)) in ring_bonds
                and self.kind(i, j) == (C, C)
                and self.length(i, j) < _METHINE_BRIDGE
            ]
            if len(flat) == 2:
                for j in flat:
                    self.set_order(i, j, AROMATIC)

    def charges(self) -> dict[int, int]:
        """Charges of nitro groups, ammonium, and of acids without hydrogens, as usual at pH 7."""
        found: dict[int, int] = {}
        oxides = {
            atom
            for pair, order in self.orders.items()
            if order == DOUBLE and O in (self.element[pair[0]], self.element[pair[1]])
            for atom in pair
        }
        for i in self.atoms:
            # Oxygens at the end with a bond still open: not double, and without a hydrogen.
            single_oxygens = [j for j in self.ends(i) if self.element[j] == O]
            if self.element[i] == N and len(self.neighbors[i]) == 4:
                found[i] = 1
            if self.element[i] == N and i in oxides and single_oxygens:
                found[i] = 1
            if self.element[i] in (C, N, P, S) and i in oxides:
                found.update(dict.fromkeys(single_oxygens, -1))
        return found
