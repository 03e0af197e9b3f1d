"""The guide that keeps backbones plausible on a path: which residues it leads, and where to."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from . import _core
from .molecule import Molecule
from .quality_terms import find_backbone, ramachandran_densities

_MOST_DEGREE = 3.0  # that a peptide plane turns at a time
# levels of the map that hold 90 and 99 % of its data
_CORE, _ALLOWED = 17.0, 1.0
_NOT_ON_THE_MAP = frozenset(("GLY", "PRO"))


@dataclass(frozen=True, eq=False)
class Torsions:
    """Residues with phi and psi that the map tells about.

    Attributes:
        atoms: (n, 5) C before, N, CA, C, N after.
        density: (n,) on the map, at the molecule's positions.
        planes: (n, 2) index of the peptide plane before and after.
        plane_atoms: of each plane the two CA, and C, O, N, H between.
        turns: whether a plane turns; that before a proline does not.
    """

    atoms: NDArray[np.int32]
    density: NDArray[np.float64]
    planes: NDArray[np.int32]
    plane_atoms: list[tuple[tuple[int, int], list[int]]]
    turns: list[bool]


def torsions_of(molecule: Molecule) -> Torsions | None:
    """Find them; None without a map or a residue on it."""
    densities = ramachandran_densities()
    if densities is None:
        return None
    backbone = find_backbone(molecule.topology, molecule.bonds)
    before = {after: k for k, after in enumerate(backbone.next) if after is not None}
    hydrogens: dict[int, list[int]] = {}
    for pair in molecule.bonds.tolist():
        for atom, other in (pair, pair[::-1]):
            if molecule.elements[other] == 1:
                hydrogens.setdefault(atom, []).append(other)
    plane_of, plane_atoms, turns = {}, [], []
    for k, own in enumerate(backbone.residues):
        if backbone.next[k] is None:
            continue
        after = backbone.residues[backbone.next[k]]
        atoms = [own["C"], after["N"], *hydrogens.get(after["N"], ())]
        if "O" in own:
            atoms.append(own["O"])
        plane_of[k] = len(plane_atoms)
        plane_atoms.append(((own["CA"], after["CA"]), atoms))
        turns.append(backbone.names[backbone.next[k]] != "PRO")
    rows, planes = [], []
    for k, own in enumerate(backbone.residues):
        if k not in plane_of or k not in before or backbone.names[k] in _NOT_ON_THE_MAP:
            continue
        ahead, after = backbone.residues[before[k]], backbone.residues[backbone.next[k]]
        rows.append([ahead["C"], own["N"], own["CA"], own["C"], after["N"]])
        planes.append([plane_of[before[k]], plane_of[k]])
    if not rows:
        return None
    table = np.array(rows, dtype=np.int32)
    side = len(densities)
    phi = _torsion(molecule.positions, table[:, [0, 1, 2, 3]])
    psi = _torsion(molecule.positions, table[:, [1, 2, 3, 4]])
    cells = [np.rint((angle + 180) / 360 * side).astype(int) % side for angle in (psi, phi)]
    return Torsions(
        atoms=table,
        density=densities[cells[0], cells[1]],
        planes=np.array(planes, dtype=np.int32),
        plane_atoms=plane_atoms,
        turns=turns,
    )


def _torsion(positions: NDArray[np.float64], atoms: NDArray[np.int32]) -> NDArray[np.float64]:
    """Torsions of rows of four atoms, degree."""
    a, b, c, d = (positions[atoms[:, k]] for k in range(4))
    ab, bc, cd = b - a, c - b, d - c
    m, n = np.cross(ab, bc), np.cross(bc, cd)
    length = np.linalg.norm(bc, axis=1)
    return np.degrees(np.arctan2(length * (ab * n).sum(1), (m * n).sum(1)))


def make_guide(own: Torsions, other_density: dict[int, float]) -> _core.BackboneGuide:
    """Lead residues that are to end in the core back to it, and others out of where they are
    outliers.

    Args:
        own: of the molecule that moves.
        other_density: on the map at the other end, by the CA atom of the molecule that moves.
    """
    planes = np.where(np.array(own.turns)[own.planes], own.planes, -1)
    to_core = [
        other_density.get(int(ca), float(density)) >= _CORE
        for density, ca in zip(own.density, own.atoms[:, 2], strict=True)
    ]
    return _core.BackboneGuide(
        ramachandran_densities().ravel(),
        _CORE,
        _ALLOWED,
        np.hstack([own.atoms, planes]).astype(np.int32),
        np.array(to_core, dtype=np.uint8),
        own.plane_atoms,
        math.radians(_MOST_DEGREE),
    )


def outlier_atoms(other: Torsions) -> NDArray[np.int32]:
    """Atoms of peptide planes, CA left out, on both sides of a residue that is an outlier."""
    atoms: set[int] = set()
    for planes in other.planes[other.density < _ALLOWED]:
        for plane in planes:
            atoms.update(other.plane_atoms[plane][1])
    return np.array(sorted(atoms), dtype=np.int32)
