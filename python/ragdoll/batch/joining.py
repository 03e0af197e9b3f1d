"""A start for large molecules: pieces that RDKit embeds alone, joined at single bonds.

Embedding a whole molecule takes time by the square and more of its atoms, and fails for hundreds.
Pieces are cut at acyclic single bonds that turn freely. Each is embedded with the atom at the other
end of every cut; two pieces are laid on each other at the two atoms that they share, and turned
about the bond to where they keep away from what is there already.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from rdkit import Chem
from rdkit.Chem import rdMolTransforms
from scipy.spatial import cKDTree

from ..errors import InputError

PIECE = 16  # heavy atoms that a piece may have, where the molecule can be cut
_TURNS = 24  # angles that are tried about a bond
_ENOUGH = 3.6  # angstrom between heavy atoms; no better angle is looked for
_CLOSE = 0.9  # angstrom between any two atoms; nearer ones overlap
_ATTEMPTS = 12  # to join the pieces without overlaps
_GAP = 3.0  # angstrom between fragments

# whether the reference atoms of a double bond lie on one side
_SIDES = {
    Chem.BondStereo.STEREOZ: True,
    Chem.BondStereo.STEREOCIS: True,
    Chem.BondStereo.STEREOE: False,
    Chem.BondStereo.STEREOTRANS: False,
}

#: embeds a small molecule with hydrogens, in place, with a seed of its own
Embed = Callable[[Chem.Mol, int], None]


def join_pieces(mol: Chem.Mol, embed: Embed, seed: int) -> None:
    """Give a molecule with hydrogens one conformer.

    Raises:
        InputError: a piece cannot be embedded, pieces cannot be placed, or the configuration is not
            the one that is asked for.
    """
    piece_of, cuts = _pieces(mol)
    parts = [
        _embedded(mol, np.flatnonzero(piece_of == k), cuts, embed, k)
        for k in range(piece_of.max() + 1)
    ]
    random = np.random.default_rng(seed)
    for attempt in range(_ATTEMPTS):
        # straight on at first, then at random
        places = _placed(mol, parts, piece_of, cuts, random if attempt else None)
        if _are_apart(places):
            break
    else:
        raise InputError("its pieces overlap where they are joined")
    conformer = Chem.Conformer(len(places))
    conformer.Set3D(True)
    conformer.SetPositions(places)
    mol.RemoveAllConformers()
    mol.AddConformer(conformer, assignId=True)
    _check_configuration(mol)


def _placed(mol, parts, piece_of, cuts, random) -> NDArray[np.float64]:
    """All pieces joined; unbonded fragments side by side."""
    places = np.full((mol.GetNumAtoms(), 3), np.nan)
    placed = np.zeros(len(places), dtype=bool)
    for first, (atoms, own) in enumerate(parts):
        if placed[atoms[0]]:
            continue
        before = placed.copy()
        places[atoms] = [own[atom] for atom in atoms]
        placed[atoms] = True
        _join_all(mol, first, parts, piece_of, cuts, places, placed, before, random)
        if before.any():
            new = placed & ~before
            places[new, 0] += places[before, 0].max() - places[new, 0].min() + _GAP
    return places


def _pieces(mol: Chem.Mol) -> tuple[NDArray[np.int64], list[tuple[int, int]]]:
    """The piece of each atom, and the bonds between pieces."""
    parent = list(range(mol.GetNumAtoms()))
    weight = [int(atom.GetAtomicNum() > 1) for atom in mol.GetAtoms()]

    def root(k: int) -> int:
        while parent[k] != k:
            parent[k] = parent[parent[k]]
            k = parent[k]
        return k

    def merge(i: int, j: int) -> None:
        i, j = root(i), root(j)
        if i != j:
            parent[j] = i
            weight[i] += weight[j]

    free = []
    for bond in mol.GetBonds():
        ends = bond.GetBeginAtom(), bond.GetEndAtom()
        i, j = (end.GetIdx() for end in ends)
        is_free = (
            bond.GetBondType() == Chem.BondType.SINGLE
            and not bond.IsInRing()
            and not bond.GetIsConjugated()
            and all(end.GetAtomicNum() > 1 and end.GetDegree() > 1 for end in ends)
        )
        if is_free:
            free.append((i, j))
        else:
            merge(i, j)
    for i, j in free:
        if weight[root(i)] + weight[root(j)] <= PIECE:
            merge(i, j)
    roots = np.array([root(k) for k in range(len(parent))])
    numbers = {value: k for k, value in enumerate(dict.fromkeys(roots.tolist()))}
    piece_of = np.array([numbers[value] for value in roots.tolist()])
    cuts = [(i, j) for i, j in free if piece_of[i] != piece_of[j]]
    return piece_of, cuts


def _embedded(
    mol: Chem.Mol,
    atoms: NDArray[np.int64],
    cuts: list[tuple[int, int]],
    embed: Embed,
    number: int,
) -> tuple[list[int], dict[int, NDArray[np.float64]]]:
    """A piece's atoms, and the places of these and of the atoms at the other ends of its cuts."""
    inside = set(atoms.tolist())
    caps = {j for i, j in cuts if i in inside} | {i for i, j in cuts if j in inside}
    order = sorted(inside | caps)
    index = {atom: k for k, atom in enumerate(order)}
    piece = Chem.RWMol()
    for atom in order:
        copy = Chem.Atom(mol.GetAtomWithIdx(atom))
        if atom in caps:  # hydrogens take the place of what lies beyond
            copy.SetFormalCharge(0)
            copy.SetChiralTag(Chem.ChiralType.CHI_UNSPECIFIED)
            copy.SetNoImplicit(False)
            copy.SetNumRadicalElectrons(0)
            copy.SetIsAromatic(False)
            copy.SetNumExplicitHs(0)
        piece.AddAtom(copy)
    copies: list[tuple[Chem.Bond, int]] = []
    # in the order of the molecule's own bonds, on which the hands of centres depend
    for bond in mol.GetBonds():
        i, j = bond.GetBeginAtomIdx(), bond.GetEndAtomIdx()
        if not (i in index and j in index) or (i in caps and j in caps):
            continue
        piece.AddBond(index[i], index[j], bond.GetBondType())
        copy = piece.GetBondBetweenAtoms(index[i], index[j])
        copy.SetIsAromatic(bond.GetIsAromatic())
        copies.append((bond, copy.GetIdx()))
    for bond, number_in_piece in copies:
        ends = list(bond.GetStereoAtoms())
        if len(ends) == 2 and all(end in index for end in ends):
            copy = piece.GetBondWithIdx(number_in_piece)
            copy.SetStereoAtoms(index[ends[0]], index[ends[1]])
            copy.SetStereo(bond.GetStereo())
    small = piece.GetMol()
    try:
        Chem.SanitizeMol(small)
    except Chem.MolSanitizeException as error:
        raise InputError(f"a piece of it makes no sense: {error}") from None
    full = Chem.AddHs(small)
    embed(full, number)
    found = full.GetConformer().GetPositions()
    return sorted(inside), {atom: found[k] for atom, k in index.items()}


def _join_all(mol, first, parts, piece_of, cuts, places, placed, before, random) -> None:
    """Place all pieces that hang on the first one, outward."""
    neighbours: dict[int, list[tuple[int, int]]] = {}
    for i, j in cuts:
        neighbours.setdefault(int(piece_of[i]), []).append((i, j))
        neighbours.setdefault(int(piece_of[j]), []).append((j, i))
    heavy = np.array([atom.GetAtomicNum() > 1 for atom in mol.GetAtoms()])
    waiting = [first]
    while waiting:
        piece = waiting.pop(0)
        for near, far in neighbours.get(piece, []):
            other = int(piece_of[far])
            if placed[far]:
                continue
            atoms, own = parts[other]
            # where this piece has the atom at the other end of the bond
            cap = parts[piece][1][far] - parts[piece][1][near]
            cap = _turned_as(parts[piece], places, near) @ cap + places[near]
            others = placed & heavy & ~before
            others[near] = False  # all that is left is four bonds away or more, but for the ends
            best = _best_turn(
                np.array([own[atom] for atom in atoms]),
                own[far],
                own[near],
                cap,
                places[near],
                places[others],
                heavy[atoms],
                random,
            )
            places[atoms] = best
            placed[atoms] = True
            waiting.append(other)


def _turned_as(part, places, centre: int) -> NDArray[np.float64]:
    """The rotation that a placed piece has undergone (Kabsch 1976)."""
    atoms, own = part
    before = np.array([own[atom] for atom in atoms]) - own[centre]
    after = places[atoms] - places[centre]
    u, _, vt = np.linalg.svd(before.T @ after)
    sign = np.sign(np.linalg.det(u @ vt)) or 1.0
    return (u @ np.diag([1.0, 1.0, sign]) @ vt).T


def _best_turn(own, far, near, cap, at_near, others, is_heavy, random) -> NDArray[np.float64]:
    """A piece laid on a bond, turned about it to where it is furthest from the others.

    Args:
        own: (n, 3) of the piece.
        far, near: the bond's ends in the piece; ``far`` is its own.
        cap, at_near: where these belong.
        others: (m, 3) heavy atoms that are placed.
        is_heavy: (n,) which of the piece's are.
        random: where the first angle is not the stretched one.
    """
    axis = (at_near - cap) / np.linalg.norm(at_near - cap)
    laid = (own - far) @ _rotation_between(near - far, axis).T
    best, widest = None, -1.0
    first = 0.0 if random is None else 2 * np.pi * random.random()
    for k in range(_TURNS):
        angle = first + (k + 1) // 2 * (-1) ** k * 2 * np.pi / _TURNS
        turned = laid @ _rotation_about(axis, angle).T + cap
        mine = turned[is_heavy]
        if len(mine) == 0 or len(others) == 0:
            return turned
        gaps = np.linalg.norm(mine[:, None] - others, axis=-1)
        gaps[np.linalg.norm(mine - cap, axis=1) < 1e-6] = np.inf  # the bond's own end
        widest_here = float(gaps.min())
        if widest_here > widest:
            best, widest = turned, widest_here
        if widest >= _ENOUGH:
            break
    return best


def _rotation_about(axis, angle: float) -> NDArray[np.float64]:
    """Rodrigues' rotation."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def _rotation_between(start, end) -> NDArray[np.float64]:
    """The shortest rotation of one direction to another."""
    start = start / np.linalg.norm(start)
    axis = np.cross(start, end)
    length = np.linalg.norm(axis)
    if length < 1e-9:
        if start @ end > 0:
            return np.eye(3)
        axis = np.cross(start, np.eye(3)[np.argmin(np.abs(start))])
        return _rotation_about(axis / np.linalg.norm(axis), np.pi)
    return _rotation_about(axis / length, np.arctan2(length, start @ end))


def _are_apart(places: NDArray[np.float64]) -> bool:
    if not np.isfinite(places).all():
        raise InputError("its pieces cannot be placed")
    distances, _ = cKDTree(places).query(places, k=2)
    return bool(distances[:, 1].min() >= _CLOSE)


def _check_configuration(mol: Chem.Mol) -> None:
    made = Chem.Mol(mol)
    Chem.AssignStereochemistryFrom3D(made)
    for atom, other in zip(mol.GetAtoms(), made.GetAtoms(), strict=True):
        tag = atom.GetChiralTag()
        if (
            tag in (Chem.ChiralType.CHI_TETRAHEDRAL_CW, Chem.ChiralType.CHI_TETRAHEDRAL_CCW)
            and other.GetChiralTag() != tag
        ):
            raise InputError(f"atom {atom.GetIdx() + 1} came out with the other hand")
    conformer = mol.GetConformer()
    for bond in mol.GetBonds():
        ends = list(bond.GetStereoAtoms())
        side = _SIDES.get(bond.GetStereo())
        if side is None or len(ends) != 2:
            continue
        middle = (bond.GetBeginAtomIdx(), bond.GetEndAtomIdx())
        angle = rdMolTransforms.GetDihedralDeg(conformer, ends[0], *middle, ends[1])
        if (abs(angle) < 90) != side:
            raise InputError(f"the double bond at atom {middle[0] + 1} came out on the other side")
