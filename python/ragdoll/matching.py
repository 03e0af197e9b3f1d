"""Matching: which atoms of two structures correspond, by aligned sequences and names."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import gemmi
import numpy as np
from numpy.typing import NDArray
from openmm.app import Chain, Residue

from .errors import InputError
from .ligand_matching import match_ligands
from .molecule import Molecule
from .sites import site_of

_LEAST_RESIDUES = 3
_POCKET = 60  # atoms that a ligand goes with
_BACKBONE = frozenset(
    ("N", "CA", "C", "O", "CB", "P", "O5'", "C5'", "C4'", "C3'", "O3'", "C2'", "C1'", "O4'")
)
# of side chains that are the same after half a turn, the atoms that change places
_TWINS = {
    "PHE": (("CD1", "CD2"), ("CE1", "CE2")),
    "TYR": (("CD1", "CD2"), ("CE1", "CE2")),
    "ASP": (("OD1", "OD2"),),
    "GLU": (("OE1", "OE2"),),
    "ARG": (("NH1", "NH2"),),
}


@dataclass(frozen=True, eq=False)
class Match:
    """Atoms that correspond.

    Attributes:
        first, second: (n,) atom indices of the two structures, heavy atoms only.
        sites: (s,) indices of these pairs that are sites: CA, or P of nucleotides.
        backbone: (b,) indices of these pairs that are backbone or CB.
        residues: pairs of residues.
        identity: share of them that have one name.
        ligands: (l,) indices of these pairs that are of ligands.
        alone: labels of ligands that one structure has alone.
    """

    first: NDArray[np.int32]
    second: NDArray[np.int32]
    sites: NDArray[np.int32]
    backbone: NDArray[np.int32]
    residues: int
    identity: float
    ligands: NDArray[np.int32]
    alone: tuple[list[str], list[str]]


def match(first: Molecule, second: Molecule) -> Match:
    """Match the atoms of two structures.

    Chains are paired by their sequences, residues by global alignment, atoms by name: all heavy
    atoms of residues of one name, the backbone and CB of others. Ligands are paired by elements and
    bonds, the nearest first. Where a side chain looks the same after half a turn (Phe, Tyr, Asp,
    Glu, Arg), the names are taken that lie nearer.

    Raises:
        InputError: the structures have too little in common.
    """
    pairs: list[tuple[Residue, Residue]] = []
    for one, other in _paired_chains(first, second):
        pairs.extend(_aligned(_polymer(one), _polymer(other)))
    residues = [(a, b) for a, b in pairs if site_of(a) is not None]
    same = sum(a.name == b.name for a, b in residues)
    share = same / len(residues) if residues else 0.0
    if len(residues) < _LEAST_RESIDUES or share < least_identity(len(residues)):
        raise InputError(
            f"{first.source} and {second.source} have too little in common for a path: "
            f"{same} of {len(residues)} aligned residues are the same; choose structures of one "
            "molecule, and their chains."
        )
    atoms: list[tuple[int, int]] = []
    sites: list[int] = []
    backbone: list[int] = []
    for one, other in pairs:
        names = _twin_names(first, second, one, other)
        theirs = {atom.name: atom for atom in other.atoms()}
        for atom in one.atoms():
            partner = theirs.get(names.get(atom.name, atom.name))
            if atom.element.atomic_number == 1 or partner is None:
                continue
            if partner.element is not atom.element:
                continue
            if one.name != other.name and atom.name not in _BACKBONE:
                continue
            if atom.index == site_of(one):
                sites.append(len(atoms))
            if site_of(one) is not None and atom.name in _BACKBONE:
                backbone.append(len(atoms))
            atoms.append((atom.index, partner.index))
    if len(sites) < _LEAST_RESIDUES:
        raise InputError(
            f"{first.source} and {second.source} have {len(sites)} CA or P atoms in common; a path "
            f"needs {_LEAST_RESIDUES} at least."
        )
    polymer = np.array(atoms, dtype=np.int32)
    ours, theirs = polymer[sites].T
    lay = rigid_move(second.positions[theirs], first.positions[ours])
    of_ligands, alone = match_ligands(first, second, lay(second.positions))
    table = np.concatenate([polymer, of_ligands])
    return Match(
        first=np.ascontiguousarray(table[:, 0]),
        second=np.ascontiguousarray(table[:, 1]),
        sites=np.array(sites, dtype=np.int32),
        backbone=np.array(backbone, dtype=np.int32),
        residues=len(residues),
        identity=share,
        ligands=np.arange(len(polymer), len(table), dtype=np.int32),
        alone=alone,
    )


def least_identity(count: int) -> float:
    """The share of aligned residues that unrelated sequences seldom have alike (Rost, Protein Eng.
    12, 85, 1999): 0.22 of 300, 0.32 of 80, all of 11.
    """
    return min(1.0, 4.8 * count ** (-0.32 * (1 + math.exp(-count / 1000))))


def placed(first: Molecule, second: Molecule, pair: Match) -> NDArray[np.float64]:
    """All atoms of the first structure where the second one would have them.

    Atoms that correspond are where they are there, hydrogens of one name at one atom too; each
    other one goes with the nearest that do, along the bonds, or else in space. A ligand that the
    second structure does not have goes with what is around it, as a whole.

    Returns:
        (N, 3), nm.
    """
    places = np.full((len(first), 3), np.nan)
    places[pair.first] = second.positions[pair.second]
    neighbours: list[list[int]] = [[] for _ in range(len(first))]
    for i, j in first.bonds.tolist():
        neighbours[i].append(j)
        neighbours[j].append(i)
    known = ~np.isnan(places[:, 0])
    _place_hydrogens(first, second, pair, places, neighbours)
    here = first.positions[pair.first]
    _place_strangers(first, pair, places, neighbours, known)
    for atom in np.flatnonzero(np.isnan(places[:, 0])).tolist():
        around = _nearest_known(atom, neighbours, known)
        if len(around) < 3:
            distances = ((here - first.positions[atom]) ** 2).sum(axis=1)
            around = pair.first[np.argsort(distances)[:8]].tolist()
        move = rigid_move(first.positions[around], places[around])
        places[atom] = move(first.positions[atom])
    return places


def _place_strangers(
    first: Molecule,
    pair: Match,
    places: NDArray[np.float64],
    neighbours: Sequence[Sequence[int]],
    known: NDArray[np.bool_],
) -> None:
    """Molecules none of whose atoms are known."""
    here = first.positions[pair.first]
    seen: set[int] = set()
    for start in np.flatnonzero(~known).tolist():
        if start in seen:
            continue
        piece = [start]
        seen.add(start)
        for atom in piece:
            fresh = [other for other in neighbours[atom] if other not in seen]
            seen.update(fresh)
            piece += fresh
        if known[piece].any():
            continue
        distances = np.min(
            [((here - first.positions[atom]) ** 2).sum(axis=1) for atom in piece], axis=0
        )
        around = pair.first[np.argsort(distances, kind="stable")[:_POCKET]]
        move = rigid_move(first.positions[around], places[around])
        places[piece] = move(first.positions[piece])


def _place_hydrogens(
    first: Molecule,
    second: Molecule,
    pair: Match,
    places: NDArray[np.float64],
    neighbours: Sequence[Sequence[int]],
) -> None:
    """Hydrogens that both structures have."""
    names = [atom.name for atom in first.topology.atoms()]
    theirs: dict[int, dict[str, int]] = {}
    other_names = [atom.name for atom in second.topology.atoms()]
    for i, j in second.bonds.tolist():
        for heavy, light in ((i, j), (j, i)):
            if second.elements[light] == 1:
                theirs.setdefault(heavy, {})[other_names[light]] = light
    for own, other in zip(pair.first.tolist(), pair.second.tolist(), strict=True):
        for atom in neighbours[own]:
            if first.elements[atom] == 1 and names[atom] in theirs.get(other, {}):
                places[atom] = second.positions[theirs[other][names[atom]]]


def _nearest_known(
    atom: int, neighbours: Sequence[Sequence[int]], known: NDArray[np.bool_]
) -> list[int]:
    """The nearest atoms along the bonds that are known: four of them, or what there is."""
    seen, front, found = {atom}, [atom], []
    while front and len(found) < 4 and len(seen) < 60:
        front = [b for a in front for b in neighbours[a] if b not in seen and not seen.add(b)]
        found += [a for a in front if known[a]]
    return found


def rigid_move(
    moved: NDArray[np.float64],
    fixed: NDArray[np.float64],
    weights: NDArray[np.float64] | None = None,
):
    """The move of a body that brings points onto others, by weighted least squares (Kabsch)."""
    one, other = (np.average(points, axis=0, weights=weights) for points in (moved, fixed))
    left = moved - one if weights is None else (moved - one) * weights[:, None]
    u, _, vt = np.linalg.svd(left.T @ (fixed - other))
    u[:, -1] *= np.sign(np.linalg.det(u @ vt)) or 1.0
    return lambda point: (point - one) @ (u @ vt) + other


def _polymer(chain: Chain) -> list[Residue]:
    return [residue for residue in chain.residues() if site_of(residue) is not None]


def _paired_chains(first: Molecule, second: Molecule) -> list[tuple[Chain, Chain]]:
    """Each chain of the first with the one of the second that has most residues alike."""
    theirs = [chain for chain in second.topology.chains() if _polymer(chain)]
    pairs = []
    for chain in first.topology.chains():
        own = _polymer(chain)
        if not own or not theirs:
            continue
        counts = [
            (sum(a.name == b.name for a, b in _aligned(own, _polymer(other))), other.id == chain.id)
            for other in theirs
        ]
        best = max(range(len(theirs)), key=lambda k: counts[k])
        pairs.append((chain, theirs.pop(best)))
    return pairs


def _aligned(one: Sequence[Residue], other: Sequence[Residue]) -> list[tuple[Residue, Residue]]:
    """Residues that correspond, by global alignment of names."""
    if not one or not other:
        return []
    scoring = gemmi.AlignmentScoring()
    scoring.match, scoring.mismatch, scoring.gapo, scoring.gape = 4, -1, -6, -1
    result = gemmi.align_string_sequences(
        [residue.name for residue in one], [residue.name for residue in other], [], scoring
    )
    pairs = []
    i = j = 0
    number = ""
    for letter in result.cigar_str():
        if letter.isdigit():
            number += letter
            continue
        count, number = int(number), ""
        if letter == "M":
            pairs.extend(zip(one[i : i + count], other[j : j + count], strict=True))
        i += count if letter in "MI" else 0
        j += count if letter in "MD" else 0
    return pairs


def _twin_names(first: Molecule, second: Molecule, one: Residue, other: Residue) -> dict[str, str]:
    """Names of the second residue's atoms that change places, where that brings them nearer."""
    twins = _TWINS.get(one.name, ()) if one.name == other.name else ()
    own = {atom.name: first.positions[atom.index] for atom in one.atoms()}
    theirs = {atom.name: second.positions[atom.index] for atom in other.atoms()}
    shared = [name for name in own if name in theirs and not name.startswith("H")]
    swapped = {}
    for a, b in twins:
        if a not in shared or b not in shared:
            return {}
        swapped[a], swapped[b] = b, a
    if not swapped:
        return {}
    # distances to the rest of the residue, which is what a turn about its bond changes
    rest = [name for name in shared if name not in swapped]

    def mismatch(names: dict[str, str]) -> float:
        return sum(
            (
                np.linalg.norm(own[name] - own[fixed])
                - np.linalg.norm(theirs[names.get(name, name)] - theirs[fixed])
            )
            ** 2
            for name in swapped
            for fixed in rest
        )

    return swapped if mismatch(swapped) < mismatch({}) else {}
