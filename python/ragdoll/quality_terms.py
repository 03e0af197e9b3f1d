"""What of a molecule is measured: backbone, ideal values, bounds; and the Ramachandran map."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from openmm.app import Topology

from . import _core

# Engh and Huber, International Tables for Crystallography F (2001), table 18.3.2.3: mean and
# standard deviation, nm; + is an atom of the next residue
_IDEAL_BONDS = {
    ("N", "CA"): (0.1459, 0.0020),
    ("CA", "C"): (0.1525, 0.0026),
    ("C", "O"): (0.1229, 0.0019),
    ("C", "+N"): (0.1336, 0.0023),
}
# degree
_IDEAL_ANGLES = {
    ("N", "CA", "C"): (111.0, 2.7),
    ("CA", "C", "+N"): (117.2, 2.2),
    ("C", "+N", "+CA"): (121.7, 2.5),
    ("CA", "C", "O"): (120.1, 2.1),
    ("O", "C", "+N"): (122.7, 1.6),
}
# MDAnalysis says that these levels hold 90 and 99 % of the data of its map
_CORE, _ALLOWED = 17.0, 1.0
_NOT_ON_THE_MAP = frozenset(("GLY", "PRO"))

# by the numbers in a trajectory file's tether_kinds
_BOUND_KINDS = (
    "user",
    "hydrogen_bond",
    "salt_bridge",
    "hydrophobic",
    "stacking",
    "backbone",
)


@dataclass
class Backbone:
    """Peptides of a topology, as atom indices.

    Attributes:
        residues: of each residue that has one, the atoms N, CA, C, and O if it has one.
        next: for each residue of ``residues``, the index there of the one that follows, or None.
        names: names of the residues.
    """

    residues: list[dict[str, int]] = field(default_factory=list)
    next: list[int | None] = field(default_factory=list)
    names: list[str] = field(default_factory=list)


def find_backbone(topology: Topology, bonds: NDArray[np.integer]) -> Backbone:
    """Residues with N, CA and C bonded in a row, and which C is bonded to which N.

    Args:
        topology: chains, residues and atoms.
        bonds: (B, 2) atom indices.
    """
    bonded = {frozenset(pair) for pair in bonds.tolist()}
    found = Backbone()
    at_nitrogen: dict[int, int] = {}
    for residue in topology.residues():
        atoms = {atom.name: atom.index for atom in residue.atoms()}
        if not {"N", "CA", "C"} <= atoms.keys():
            continue
        n, ca, c = atoms["N"], atoms["CA"], atoms["C"]
        if frozenset((n, ca)) not in bonded or frozenset((ca, c)) not in bonded:
            continue
        at_nitrogen[n] = len(found.residues)
        kept = {name: atoms[name] for name in ("N", "CA", "C")}
        if "O" in atoms and frozenset((c, atoms["O"])) in bonded:
            kept["O"] = atoms["O"]
        found.residues.append(kept)
        found.names.append(residue.name)
    of_carbon = {atoms["C"]: k for k, atoms in enumerate(found.residues)}
    found.next = [None] * len(found.residues)
    for pair in bonds.tolist():
        for c, n in (pair, pair[::-1]):
            if c in of_carbon and n in at_nitrogen and of_carbon[c] != at_nitrogen[n]:
                found.next[of_carbon[c]] = at_nitrogen[n]
    return found


def _ideal(backbone: Backbone, table: Mapping) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    atoms, values = [], []
    for k, own in enumerate(backbone.residues):
        after = None if backbone.next[k] is None else backbone.residues[backbone.next[k]]
        for names, value in table.items():
            of = [
                (after or {}).get(name[1:]) if name[0] == "+" else own.get(name) for name in names
            ]
            if None not in of:
                atoms.append(of)
                values.append(value)
    width = len(next(iter(table)))
    return (
        np.array(atoms, dtype=np.int32).reshape(-1, width),
        np.array(values, dtype=np.float64).reshape(-1, 2),
    )


@cache
def ramachandran_densities() -> NDArray[np.float64] | None:
    """MDAnalysis' map for all residues but glycine and proline (Lovell et al. 2003), (90, 90): a
    row for each psi and a column for each phi, from -180 degrees on. None without MDAnalysis.
    """
    package = find_spec("MDAnalysis")  # importing all of it would take a second
    if package is None:
        return None
    path = Path(package.origin).parent / "analysis" / "data" / "rama_ref_data.npy"
    if not path.is_file():
        from MDAnalysis.analysis.data.filenames import Rama_ref as path
    return np.load(path).astype(np.float64)


@dataclass(frozen=True)
class QualityTerms:
    """What is measured, and how much of it there is.

    Attributes:
        check: core's, which measures.
        peptide_bonds: how many omegas.
        residues: how many are on the Ramachandran map; None without a map.
        ideal: whether there is a backbone to hold against ideal values.
        bounds: how many upper bounds of each kind, by name.
    """

    check: _core.QualityCheck
    peptide_bonds: int
    residues: int | None
    ideal: bool
    bounds: dict[str, int]


def quality_terms(
    molecule: _core.Molecule,
    topology: Topology,
    bonds: NDArray[np.integer],
    framework: Mapping[str, NDArray] | None = None,
) -> QualityTerms:
    """Find what is to be measured.

    Args:
        molecule: as core sees it, at the positions that frames are held against.
        topology: chains, residues and atoms.
        bonds: (B, 2) atom indices.
        framework: arrays of a trajectory file; its tethers are the bounds.
    """
    backbone = find_backbone(topology, bonds)
    before = {after: k for k, after in enumerate(backbone.next) if after is not None}
    omegas, torsions = [], []
    for k, own in enumerate(backbone.residues):
        if backbone.next[k] is None:
            continue
        after = backbone.residues[backbone.next[k]]
        omegas.append([own["CA"], own["C"], after["N"], after["CA"]])
        if k in before and backbone.names[k] not in _NOT_ON_THE_MAP:
            torsions.append(
                [backbone.residues[before[k]]["C"], own["N"], own["CA"], own["C"], after["N"]]
            )
    densities = ramachandran_densities()
    ideal_bonds, bond_values = _ideal(backbone, _IDEAL_BONDS)
    ideal_angles, angle_values = _ideal(backbone, _IDEAL_ANGLES)
    pairs, lengths, groups, kinds = _bounds(framework or {})
    check = _core.QualityCheck(
        molecule,
        ideal_bonds=ideal_bonds,
        ideal_bond_values=bond_values,
        ideal_angles=ideal_angles,
        ideal_angle_values=angle_values,
        omegas=np.array(omegas, dtype=np.int32).reshape(-1, 4),
        backbones=np.array(torsions, dtype=np.int32).reshape(-1, 5),
        alphas=np.array([own["CA"] for own in backbone.residues], dtype=np.int32),
        ramachandran=None if densities is None else densities.ravel(),
        core=_CORE,
        allowed=_ALLOWED,
        bounds=pairs,
        bound_lengths=lengths,
        bound_groups=groups,
        groups=len(kinds),
    )
    return QualityTerms(
        check=check,
        peptide_bonds=len(omegas),
        residues=None if densities is None else len(torsions),
        ideal=len(ideal_bonds) > 0,
        bounds=kinds,
    )


def _bounds(framework: Mapping[str, NDArray]):
    """Tethers, their lengths (nm), the group of each, and how many each group has by its name."""
    pairs = np.asarray(framework.get("tethers", ()), dtype=np.int32).reshape(-1, 2)
    lengths = np.asarray(framework.get("tether_lengths", ()), dtype=np.float64)
    numbers = np.asarray(framework.get("tether_kinds", np.zeros(len(pairs))), dtype=np.int64)
    present, groups = np.unique(numbers, return_inverse=True)
    kinds = {}
    for group, number in enumerate(present.tolist()):
        known = 0 <= number < len(_BOUND_KINDS)
        kinds[_BOUND_KINDS[number] if known else f"kind_{number}"] = int((groups == group).sum())
    return pairs, lengths, groups.astype(np.int32), kinds
