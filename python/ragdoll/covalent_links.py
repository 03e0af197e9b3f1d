"""Bonds between a ligand and what it is bonded to: found, checked, and what leaves for them."""

import math

import numpy as np
from numpy.typing import NDArray
from rdkit import Chem

from .elements import COVALENT_RADII, IS_METAL
from .ligand_template import ideal_length
from .residues import DOUBLE, SINGLE, ResidueTemplate

# All lengths in this file are in angstrom.
LONGEST_LINK = 2.5  # that a user may ask for
_LINK_SLACK = 0.25  # above the sum of covalent radii, where a clash must not become a bond
_RECORD_SLACK = 0.8  # the same for bonds that the file records
_LONGEST_IMINE = 1.36
_FLAT = 0.25  # a tetrahedral centre lies further above the plane of three neighbours

# atoms of amino acids that ligands bind to; elsewhere any N, O, S or Se
_REACTIVE = {
    "CYS": {"SG", "SE"}, "SER": {"OG"}, "THR": {"OG1"}, "TYR": {"OH"}, "LYS": {"NZ"},
    "HIS": {"ND1", "NE2"}, "ASP": {"OD1", "OD2"}, "GLU": {"OE1", "OE2"}, "ASN": {"ND2"},
    "GLN": {"NE2"}, "ARG": {"NE", "NH1", "NH2"}, "TRP": {"NE1"}, "MET": {"SD"},
}  # fmt: skip
_MOST_VALENCE = {5: 4, 6: 4, 7: 3, 8: 2, 14: 4, 15: 5, 16: 2, 34: 2}


def is_link(first: int, second: int, distance: float, *, recorded: bool = False) -> bool:
    """Whether two elements so far apart are bonded."""
    if IS_METAL[first] or IS_METAL[second] or first == 1 or second == 1:
        return False
    slack = _RECORD_SLACK if recorded else _LINK_SLACK
    return distance < COVALENT_RADII[first] + COVALENT_RADII[second] + slack


def is_reactive(template: ResidueTemplate | None, name: str, element: int) -> bool:
    """Whether ligands are known to bind to such an atom of a residue."""
    if template is not None and template.is_amino_acid:
        own = template.atom_name(name)
        return own == "N" or own in _REACTIVE.get(template.name, ())
    return element in (7, 8, 16, 34)


def link_order(mol: Chem.RWMol, local: int, other: int, distance: float) -> int:
    """The order of a bond from a ligand's atom to an element outside: 2 of a Schiff base."""
    atom = mol.GetAtomWithIdx(local)
    kinds = {atom.GetAtomicNum(), other}
    if kinds == {6, 7} and distance < _LONGEST_IMINE and _valence(atom) <= 2:
        return DOUBLE
    return SINGLE


def make_room(
    mol: Chem.RWMol, local: int, partner: NDArray[np.float64], order: int = SINGLE
) -> tuple[bool, str, list[int]]:
    """Let a ligand's atom have one more bond.

    A hydrogen leaves, or where the atom is tetrahedral a double or triple bond loses an order:
    that was the warhead before it reacted.

    Args:
        mol: hydrogens without a place are counted as explicit ones; changed.
        local: the atom.
        partner: (3,) where its new neighbour is.
        order: of the new bond.

    Returns:
        Whether there is room now, a phrase on what was done, and the hydrogens that left.
    """
    atom = mol.GetAtomWithIdx(local)
    most = _MOST_VALENCE.get(atom.GetAtomicNum(), 8) + max(0, atom.GetFormalCharge())
    if atom.GetAtomicNum() == 16 and _valence(atom) > 2:
        most = 6
    done, left = "", []
    while _valence(atom) + order > most:
        multiple = _reacted_bond(mol, atom, partner)
        hydrogens = [n for n in atom.GetNeighbors() if n.GetAtomicNum() == 1]
        if multiple is not None:
            other = multiple.GetOtherAtom(atom)
            to = (
                Chem.BondType.DOUBLE
                if multiple.GetBondType() == Chem.BondType.TRIPLE
                else Chem.BondType.SINGLE
            )
            multiple.SetBondType(to)
            other.SetNumExplicitHs(other.GetNumExplicitHs() + 1)
            done = (
                "its double bond became a single one"
                if to == Chem.BondType.SINGLE
                else ("its triple bond became a double one")
            )
        elif atom.GetNumExplicitHs() > 0:
            atom.SetNumExplicitHs(atom.GetNumExplicitHs() - 1)
        elif hydrogens:
            places = mol.GetConformer().GetPositions()
            leaving = min(
                (n.GetIdx() for n in hydrogens),
                key=lambda index: float(np.linalg.norm(places[index] - partner)),
            )
            mol.RemoveBond(local, leaving)
            left.append(leaving)
            done = done or "one of its hydrogens left"
        elif atom.GetFormalCharge() < 0:
            break
        else:
            return False, done, left
    if atom.GetFormalCharge() < 0 and atom.GetAtomicNum() in (8, 16, 34, 7):
        atom.SetFormalCharge(0)
    return True, done, left


def _valence(atom: Chem.Atom) -> float:
    bonds = sum(
        bond.GetBondTypeAsDouble()
        for bond in atom.GetBonds()
        if bond.GetBondType() not in (Chem.BondType.DATIVE, Chem.BondType.ZERO)
    )
    return math.floor(bonds) + atom.GetNumExplicitHs()


def _reacted_bond(
    mol: Chem.RWMol, atom: Chem.Atom, partner: NDArray[np.float64]
) -> Chem.Bond | None:
    """A double or triple bond that the coordinates do not have any more."""
    places = mol.GetConformer().GetPositions()
    here = places[atom.GetIdx()]
    for bond in atom.GetBonds():
        if bond.GetIsAromatic() or bond.GetBondTypeAsDouble() < 2:
            continue
        other = bond.GetOtherAtom(atom)
        around = [
            places[n.GetIdx()] - here for n in atom.GetNeighbors() if n.GetAtomicNum() > 1
        ] + [partner - here]
        if bond.GetBondType() == Chem.BondType.DOUBLE and len(around) == 3:
            a, b, c = around
            normal = np.cross(b - a, c - a)
            if abs(a @ normal) > _FLAT * np.linalg.norm(normal):
                return bond
            continue
        lower = (
            Chem.BondType.SINGLE
            if bond.GetBondType() == Chem.BondType.DOUBLE
            else Chem.BondType.DOUBLE
        )
        numbers = atom.GetAtomicNum(), other.GetAtomicNum()
        middle = 0.5 * sum(ideal_length(*numbers, kind) for kind in (bond.GetBondType(), lower))
        if np.linalg.norm(places[other.GetIdx()] - here) > middle:
            return bond
    return None


def leaving_hydrogens(
    ends: list[tuple[int, int]],
    elements: NDArray[np.int32],
    charges: NDArray[np.int32],
    positions: NDArray[np.float64],
    bonds: NDArray[np.int32],
) -> list[int]:
    """Hydrogens for which there is no room beside a new bond.

    Args:
        ends: an atom and its new neighbour, each.
        elements, charges: (N,).
        positions: (N, 3).
        bonds: (B, 2), the new ones among them.
    """
    neighbors: dict[int, list[int]] = {end: [] for end, _ in ends}
    for i, j in bonds.tolist():
        for atom, other in ((i, j), (j, i)):
            if atom in neighbors:
                neighbors[atom].append(other)
    most = {7: 3, 8: 2, 16: 2, 34: 2, 6: 4, 15: 4, 5: 4}
    leaving: list[int] = []
    for end, partner in ends:
        around = [other for other in neighbors[end] if other not in leaving]
        room = most.get(int(elements[end]), 8)
        if elements[end] == 7 and charges[end] > 0:
            room += 1
        hydrogens = sorted(
            (other for other in around if elements[other] == 1),
            key=lambda other: float(np.linalg.norm(positions[other] - positions[partner])),
        )
        leaving += hydrogens[: max(0, len(around) - room)]
    return leaving
