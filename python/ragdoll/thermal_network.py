"""Thermal fluctuations: an elastic network of heavy atoms, whose bars are stiff."""

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .eigenmodes import lowest_eigenpairs, with_signs
from .errors import InputError
from .molecule import Molecule
from .neighbors import close_pairs
from .sites import site_of

if TYPE_CHECKING:
    from . import _core

#: residues of a polymer from which on a molecule has thermal fluctuations of its own
FEWEST_RESIDUES = 10
_CUTOFF = 0.6  # nm
_BAR = 100.0  # stiffness of bars, that of a contact being 1
_TORSION = 0.3  # nm^2, stiffness of the turn about a bond
_BENT = 0.2  # sine of the angle from which on three atoms have a plane
_SHIFT = 1e-4  # what makes the matrix definite
_STILL = 1e-5  # eigenvalues below are motions without force
_DEVIATION = 0.2  # nm at 300 K of a coordinate that one contact holds
_WIDEST = 0.3  # nm, which the RMSD of a mode stays below
_MOST_ATOMS = 15_000  # beyond so many, residues are rigid
_LEAST_ARM = 0.02  # nm; residues that are smaller, or thin, do not turn


def has_fluctuations(molecule: Molecule) -> bool:
    """Whether there are residues enough for thermal motion."""
    sites = (site_of(residue) for residue in molecule.topology.residues())
    return sum(site is not None for site in sites) >= FEWEST_RESIDUES


def fluctuations(
    molecule: Molecule,
    framework: "_core.Framework",
    *,
    temperature_kelvin: float = 300.0,
    count: int = 60,
) -> NDArray[np.float64]:
    """The softest motions of a framework, each as far as heat takes it.

    Heavy atoms nearer to each other than 6 angstrom are joined by springs of one constant, at rest
    in the structure (Tirion, Phys. Rev. Lett. 77, 1905, 1996), bars by springs a hundred times as
    stiff, so that bonds, angles and planar units stay, as in the torsional network model (Mendez
    and Bastolla, Phys. Rev. Lett. 104, 228103, 2010). Mode k of stiffness w has the deviation
    sqrt(kT / w); the constant makes residues of ubiquitin deviate as they do in molecular dynamics.
    Beyond 15,000 heavy atoms residues are rigid bodies (Tama et al., Proteins 41, 1, 2000).
    Hydrogens go and turn with the atoms that bear them. Atoms without bars, such as ions and
    waters, are in no mode.

    Args:
        molecule: the structure.
        framework: whose bars are stiff, and whose fixed joints stay.
        temperature_kelvin: deviations grow with its square root.
        count: how many modes at most.

    Returns:
        (n, N, 3) displacements of one deviation, nm.

    Raises:
        InputError: nothing in the molecule moves in a mode.
    """
    heavy = np.asarray(molecule.elements) > 1
    bars = np.asarray(framework.bars)
    bars = bars[heavy[bars].all(axis=1)]
    nodes = np.unique(bars)
    if len(nodes) < 3:
        raise InputError(f"{molecule.source} has too few heavy atoms for thermal motion.")
    number = np.full(len(molecule), -1)
    number[nodes] = np.arange(len(nodes))
    places = molecule.positions[nodes]
    fixed = np.asarray(framework.fixed)[nodes] != 0
    bars = number[bars]
    springs, whole = close_pairs(places, _CUTOFF), len(nodes) <= _MOST_ATOMS
    pairs = np.concatenate([springs, bars])
    stiffness = np.ones(len(pairs))
    stiffness[len(springs) :] = _BAR if whole else 1.0
    rows = [_stretches(places, pairs)]
    if whole:
        turns = _turns(places, number, np.asarray(molecule.bonds).reshape(-1, 2), heavy)
        rows.append(turns)
        stiffness = np.append(stiffness, np.full(turns.shape[0], _TORSION))
    hessian = _hessian(rows, stiffness, fixed)
    rigid = None if whole else _rigid_bodies(molecule, nodes)
    values, vectors = _softest(hessian, rigid, count)
    if not len(values):
        raise InputError(f"{molecule.source} has no mode that costs anything.")
    # a mode that hardly anything holds goes no further than others may
    widest = _WIDEST**2 * len(nodes)
    variances = _DEVIATION**2 * temperature_kelvin / 300.0 / values
    deviations = np.sqrt(variances * widest / (variances + widest))
    moves = np.zeros((len(values), len(molecule), 3))
    moves[:, nodes] = (vectors * deviations[:, None]).reshape(len(values), -1, 3)
    _carry_hydrogens(moves, molecule, heavy, number, places, bars)
    return moves


def _stretches(places: NDArray[np.float64], pairs: NDArray[np.int64]):
    """How the distance of each pair changes as atoms move, (P, 3n) sparse."""
    lines = places[pairs[:, 1]] - places[pairs[:, 0]]
    lines /= np.linalg.norm(lines, axis=1)[:, None]
    return _rows(pairs, np.stack([-lines, lines], axis=1), len(places))


def _turns(
    places: NDArray[np.float64],
    number: NDArray[np.int64],
    bonds: NDArray[np.int64],
    heavy: NDArray[np.bool_],
):
    """How the torsion about each bond changes as atoms move, rad/nm, (T, 3n) sparse.

    One for each bond between heavy atoms that have others beside: their first ones that are not in
    line with it.
    """
    beside: dict[int, list[int]] = {}
    bonds = [(int(i), int(j)) for i, j in number[bonds[heavy[bonds].all(axis=1)]] if i >= 0 <= j]
    for i, j in bonds:
        beside.setdefault(i, []).append(j)
        beside.setdefault(j, []).append(i)
    found = []
    for j, k in bonds:
        line = places[k] - places[j]
        ends = []
        for inner, outer in ((j, k), (k, j)):
            for end in beside[inner]:
                arm = places[end] - places[inner]
                wide = np.linalg.norm(np.cross(arm, line))
                if end != outer and wide > _BENT * np.linalg.norm(arm) * np.linalg.norm(line):
                    ends.append(end)
                    break
        if len(ends) == 2 and ends[0] != ends[1]:
            found.append((ends[0], j, k, ends[1]))
    torsions = np.array(found, dtype=np.int64).reshape(-1, 4)
    first, middle, last = (places[torsions[:, c]] - places[torsions[:, c + 1]] for c in range(3))
    middle, last = -middle, -last
    first = -first
    # Blondel and Karplus, J. Comput. Chem. 17, 1132, 1996
    f, g, h = -first, -middle, last
    a, b = np.cross(f, g), np.cross(h, g)
    length = np.linalg.norm(g, axis=1)[:, None]
    a2, b2 = (a**2).sum(axis=1)[:, None], (b**2).sum(axis=1)[:, None]
    fg, hg = (f * g).sum(axis=1)[:, None], (h * g).sum(axis=1)[:, None]
    one, four = -length / a2 * a, length / b2 * b
    bend = fg / (a2 * length) * a - hg / (b2 * length) * b
    return _rows(torsions, np.stack([one, -one + bend, -four - bend, four], axis=1), len(places))


def _rows(atoms: NDArray[np.int64], parts: NDArray[np.float64], count: int):
    """Rows of which each atom (R, k) has its part (R, k, 3)."""
    from scipy import sparse

    columns = 3 * atoms[:, :, None] + np.arange(3)
    rows = np.broadcast_to(np.arange(len(atoms))[:, None, None], columns.shape)
    entries = (parts.ravel(), (rows.ravel(), columns.ravel()))
    return sparse.csr_matrix(entries, shape=(len(atoms), 3 * count))


def _hessian(rows: list, stiffness: NDArray[np.float64], fixed: NDArray[np.bool_]):
    """Second derivatives of the energy, (3n, 3n) sparse; fixed atoms are held."""
    from scipy import sparse

    change = sparse.vstack(rows)
    held = sparse.diags(np.repeat(fixed, 3) * _BAR)
    return (change.T @ sparse.diags(stiffness) @ change + held).tocsc()


def _rigid_bodies(molecule: Molecule, nodes: NDArray[np.int64]):
    """Translations and rotations of each residue, orthonormal columns, (3n, m) sparse."""
    from scipy import sparse

    residue = np.array([atom.residue.index for atom in molecule.topology.atoms()])[nodes]
    order = np.argsort(residue, kind="stable")
    rows, columns, values, count = [], [], [], 0
    for atoms in np.split(order, np.flatnonzero(np.diff(residue[order])) + 1):
        arms = molecule.positions[nodes[atoms]]
        arms = arms - arms.mean(axis=0)
        basis = np.zeros((6, len(atoms), 3))
        for axis, unit in enumerate(np.eye(3)):
            basis[axis] = unit
            basis[3 + axis] = np.cross(unit, arms)
        turns, sizes, _ = np.linalg.svd(basis[3:].reshape(3, -1).T, full_matrices=False)
        turns = turns[:, sizes > _LEAST_ARM * math.sqrt(len(atoms))]
        moves = basis[:3].reshape(3, -1).T / math.sqrt(len(atoms))
        both = np.concatenate([moves, turns], axis=1)
        places = (3 * atoms[:, None] + np.arange(3)).ravel()
        rows.append(np.repeat(places, both.shape[1]))
        columns.append(np.tile(count + np.arange(both.shape[1]), len(places)))
        values.append(both.ravel())
        count += both.shape[1]
    entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    return sparse.csc_matrix(entries, shape=(3 * len(nodes), count))


def _softest(hessian, rigid, count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Stiffness (n,) and directions (n, 3N) of the softest modes that cost something."""
    matrix = hessian if rigid is None else (rigid.T @ hessian @ rigid).tocsc()
    asked = count + 6
    while True:
        values, vectors = lowest_eigenpairs(matrix, asked, _SHIFT, tolerance=1e-6)
        costs = np.flatnonzero(values > _STILL)[:count]
        # parts that nothing joins have motions without force of their own
        if len(costs) == count or asked >= matrix.shape[0]:
            break
        asked *= 2
    values, vectors = values[costs], vectors[:, costs]
    if rigid is not None:
        vectors = rigid @ vectors
    return values, with_signs(vectors.T)


def _carry_hydrogens(
    moves: NDArray[np.float64],
    molecule: Molecule,
    heavy: NDArray[np.bool_],
    number: NDArray[np.int64],
    places: NDArray[np.float64],
    bars: NDArray[np.int64],
) -> None:
    """Move hydrogens as what bears them, and as that turns by what it has bars to."""
    bonds = np.asarray(molecule.bonds, dtype=np.int64).reshape(-1, 2)
    bonds = np.concatenate([bonds, bonds[:, ::-1]])
    bonds = bonds[~heavy[bonds[:, 0]] & heavy[bonds[:, 1]]]
    bonds = bonds[number[bonds[:, 1]] >= 0]
    if not len(bonds):
        return
    hydrogens, parents = bonds[:, 0], number[bonds[:, 1]]
    both = np.concatenate([bars, bars[:, ::-1]])
    arms = places[both[:, 1]] - places[both[:, 0]]
    squares = (arms**2).sum(axis=1)
    total = np.zeros((len(places), 3, 3))
    np.add.at(
        total,
        both[:, 0],
        squares[:, None, None] * np.eye(3) - arms[:, :, None] * arms[:, None, :],
    )
    # an atom with one bar does not turn about it
    total += 1e-6 * np.eye(3)
    inverse = np.linalg.inv(total)
    nodes = np.flatnonzero(number >= 0)
    beside = molecule.positions[hydrogens] - places[parents]
    for move in moves:
        shift = move[nodes]
        moments = np.zeros_like(places)
        np.add.at(moments, both[:, 0], np.cross(arms, shift[both[:, 1]] - shift[both[:, 0]]))
        spin = np.einsum("nij,nj->ni", inverse, moments)
        move[hydrogens] = shift[parents] + np.cross(spin[parents], beside)
