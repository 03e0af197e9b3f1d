"""Ligands of two structures that correspond, by elements and bonds."""

import numpy as np
from numpy.typing import NDArray
from openmm.app import Residue
from rdkit import Chem

from .molecule import Molecule
from .residue_match import residue_label
from .residues import WATERS
from .sites import site_of

_MOST_MATCHES = 1000


def match_ligands(
    first: Molecule, second: Molecule, laid: NDArray[np.float64]
) -> tuple[NDArray[np.int32], tuple[list[str], list[str]]]:
    """Pair the heavy atoms of ligands: residues that are no part of a polymer.

    Two ligands correspond where their heavy atoms have the same elements and bonds, whatever their
    names; of several the nearest are paired, and of the ways that symmetry leaves the one that
    moves least. Ligands of one name that are not the same molecule are paired atom by atom name.

    Args:
        first, second: the structures.
        laid: (M, 3), nm: the second one's atoms, laid over the first.

    Returns:
        (n, 2) atoms that correspond, and labels of the ligands that either has alone.
    """
    ours, theirs = _ligands(first), _ligands(second)
    ways = []
    for a, one in enumerate(ours):
        for b, other in enumerate(theirs):
            pairs = _pairs(first, one, second, other, laid)
            if pairs is not None:
                off = first.positions[pairs[:, 0]] - laid[pairs[:, 1]]
                ways.append((float((off**2).sum(axis=1).mean()), a, b, pairs))
    found: list[NDArray[np.int32]] = []
    left, right = set(range(len(ours))), set(range(len(theirs)))
    for _, a, b, pairs in sorted(ways, key=lambda way: way[:3]):
        if a in left and b in right:
            found.append(pairs)
            left.remove(a)
            right.remove(b)
    for a in sorted(left):
        for b in sorted(right):
            if ours[a].name == theirs[b].name:
                pairs = _named_pairs(ours[a], theirs[b])
                if len(pairs):
                    found.append(pairs)
                    left.remove(a)
                    right.remove(b)
                    break
    alone = (
        [residue_label(ours[a]) for a in sorted(left)],
        [residue_label(theirs[b]) for b in sorted(right)],
    )
    if not found:
        return np.empty((0, 2), dtype=np.int32), alone
    return np.concatenate(found), alone


def _ligands(molecule: Molecule) -> list[Residue]:
    return [
        residue
        for residue in molecule.topology.residues()
        if site_of(residue) is None and residue.name not in WATERS and _heavy(residue)
    ]


def _heavy(residue: Residue) -> list[int]:
    return [atom.index for atom in residue.atoms() if atom.element.atomic_number > 1]


def _graph(molecule: Molecule, residue: Residue) -> tuple[Chem.Mol, list[int]]:
    atoms = _heavy(residue)
    local = {atom: k for k, atom in enumerate(atoms)}
    mol = Chem.RWMol()
    for atom in atoms:
        node = Chem.Atom(int(molecule.elements[atom]))
        node.SetNoImplicit(True)
        mol.AddAtom(node)
    inside = np.isin(molecule.bonds, atoms).all(axis=1)
    for i, j in molecule.bonds[inside].tolist():
        mol.AddBond(local[i], local[j], Chem.BondType.SINGLE)
    mol.UpdatePropertyCache(strict=False)
    return mol, atoms


def _pairs(
    first: Molecule, one: Residue, second: Molecule, other: Residue, laid: NDArray[np.float64]
) -> NDArray[np.int32] | None:
    if len(_heavy(one)) != len(_heavy(other)):
        return None
    graph, ours = _graph(first, one)
    query, theirs = _graph(second, other)
    if graph.GetNumBonds() != query.GetNumBonds():
        return None
    settings = Chem.SubstructMatchParameters()
    settings.uniquify = False
    settings.maxMatches = _MOST_MATCHES
    matches = graph.GetSubstructMatches(query, settings)
    if not matches:
        return None
    here, there = first.positions[ours], laid[theirs]
    best = min(matches, key=lambda match: float(((here[list(match)] - there) ** 2).sum()))
    return np.array([(ours[k], theirs[q]) for q, k in enumerate(best)], dtype=np.int32)


def _named_pairs(one: Residue, other: Residue) -> NDArray[np.int32]:
    theirs = {atom.name: atom for atom in other.atoms()}
    pairs = [
        (atom.index, theirs[atom.name].index)
        for atom in one.atoms()
        if atom.element.atomic_number > 1
        and atom.name in theirs
        and theirs[atom.name].element is atom.element
    ]
    return np.array(pairs, dtype=np.int32).reshape(-1, 2)
