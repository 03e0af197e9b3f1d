"""Normal modes of an elastic network: springs between sites that are near each other."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from openmm.app import Residue

from .eigenmodes import lowest_eigenpairs, with_signs
from .errors import InputError
from .matching import match
from .molecule import Molecule
from .neighbors import close_pairs
from .sites import sites_of

_ANGSTROM = 10.0  # per nm
_MOST_MODES = 1000
_STILL = 1e-7  # of the largest stiffness of a site: eigenvalues below are motions without force
_SHIFT = 1e-6  # of the same: what makes the matrix definite
_NEIGHBOURHOOD = 0.8  # nm, within which the rotation of a residue is taken from other sites


@dataclass(frozen=True, eq=False, repr=False)
class Modes:
    """The softest modes of an elastic network, softest first.

    Attributes:
        molecule: whose they are.
        sites: (S,) atoms at its nodes: CA, or P of nucleotides.
        eigenvalues: (n,) stiffness, in units of the spring constant.
        vectors: (n, S, 3) directions of the sites, each mode of length 1.
        collectivity: (n,) share of the sites that a mode moves (Brueschweiler 1995), 1/S to 1.
        overlaps: (n,) |cosine| between mode and displacement to another structure, or None.
        rmsd_angstrom: of the sites from that structure, or None.
        cutoff_angstrom: up to which sites are joined by springs.
        zero_modes: motions without force, left out: 6 of a body in one piece.
    """

    molecule: Molecule
    sites: NDArray[np.int32]
    site_of_atom: NDArray[np.int32]
    eigenvalues: NDArray[np.float64]
    vectors: NDArray[np.float64]
    collectivity: NDArray[np.float64]
    cutoff_angstrom: float
    zero_modes: int
    overlaps: NDArray[np.float64] | None = None
    rmsd_angstrom: float | None = None
    notes: list[str] = field(default_factory=list)

    def __len__(self) -> int:
        """Return the number of modes."""
        return len(self.eigenvalues)

    def __repr__(self) -> str:
        """Return one line."""
        return f"<Modes of {self.molecule.source}: {len(self)} of {len(self.sites)} sites>"

    def residues(self) -> list[Residue]:
        """The residue of each site."""
        atoms = list(self.molecule.topology.atoms())
        return [atoms[site].residue for site in self.sites]

    def of_atoms(self) -> NDArray[np.float64]:
        """The modes of all atoms: each goes with its site and turns as the sites around do.

        Returns:
            (n, N, 3); the RMS over the sites is 1.
        """
        places = self.molecule.positions
        here = places[self.sites]
        scaled = self.vectors * math.sqrt(len(self.sites))
        spin = _rotations(here, scaled)
        arms = places - here[self.site_of_atom]
        return scaled[:, self.site_of_atom] + np.cross(spin[:, self.site_of_atom], arms[None])

    def as_dict(self) -> dict[str, Any]:
        """What ``ragdoll modes --json`` prints."""
        modes = []
        cumulative = None if self.overlaps is None else np.sqrt(np.cumsum(self.overlaps**2))
        for k in range(len(self)):
            mode = {
                "mode": k + 1,
                "eigenvalue": float(self.eigenvalues[k]),
                "collectivity": float(self.collectivity[k]),
            }
            if cumulative is not None:
                mode["overlap"] = float(self.overlaps[k])
                mode["cumulative_overlap"] = float(cumulative[k])
            modes.append(mode)
        return {
            "input": self.molecule.source,
            "input_hash": self.molecule.source_hash,
            "atoms": len(self.molecule),
            "sites": len(self.sites),
            "cutoff_angstrom": self.cutoff_angstrom,
            "zero_modes": self.zero_modes,
            "rmsd_angstrom": self.rmsd_angstrom,
            "modes": modes,
            "notes": list(self.notes),
        }


def modes(
    molecule: Molecule,
    *,
    count: int = 10,
    cutoff_angstrom: float = 15.0,
    towards: Molecule | None = None,
) -> Modes:
    """Normal modes of the anisotropic network model (Atilgan et al., Biophys. J. 80, 505, 2001).

    Sites within the cutoff are joined by springs of one constant, at rest in the structure. The
    matrix is sparse and is factorised once; 10,000 residues take some ten seconds.

    Args:
        molecule: the structure.
        count: how many modes, the softest.
        cutoff_angstrom: up to which sites are joined.
        towards: another structure of the molecule; overlaps with the way to it are told.

    Raises:
        InputError: an option is out of range, there are too few sites, or the other structure has
            too little in common.
    """
    if not 1 <= count <= _MOST_MODES:
        raise InputError(f"--count must be from 1 to {_MOST_MODES}, not {count}.")
    if not (math.isfinite(cutoff_angstrom) and 4 <= cutoff_angstrom <= 100):
        raise InputError(f"The cutoff must be from 4 to 100 angstrom, not {cutoff_angstrom}.")
    sites, of_atom = sites_of(molecule.topology, molecule.positions)
    if len(sites) < 4:
        raise InputError(
            f"{molecule.source} has {len(sites)} sites, too few for an elastic network; give a "
            "molecule of four residues or heavy atoms at least."
        )
    places = molecule.positions[sites]
    values, vectors, still = _softest(places * _ANGSTROM, cutoff_angstrom, count)
    notes = []
    if still > 6:
        notes.append(
            f"The network falls into pieces or hangs loosely: {still} motions cost nothing."
        )
    if len(values) < count:
        notes.append(f"There are {len(values)} modes, not {count}.")
    if not len(values):
        raise InputError(f"{molecule.source} has no mode that costs anything at this cutoff.")
    shares = (vectors**2).sum(axis=2)
    entropy = -(shares * np.log(np.maximum(shares, 1e-300))).sum(axis=1)
    overlaps = rmsd = None
    if towards is not None:
        overlaps, rmsd = _overlaps(molecule, towards, sites, vectors)
    return Modes(
        molecule=molecule,
        sites=sites,
        site_of_atom=of_atom,
        eigenvalues=values,
        vectors=vectors,
        collectivity=np.exp(entropy) / len(sites),
        cutoff_angstrom=cutoff_angstrom,
        zero_modes=still,
        overlaps=overlaps,
        rmsd_angstrom=rmsd,
        notes=notes,
    )


def _softest(
    places: NDArray[np.float64], cutoff: float, count: int
) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:
    """Eigenvalues and vectors (n, S, 3) of the softest modes, and how many cost nothing."""
    hessian = _hessian(places, cutoff)
    size = hessian.shape[0]
    scale = float(hessian.diagonal().max(initial=0.0))
    if scale == 0:
        return np.empty(0), np.empty((0, len(places), 3)), size
    asked = min(count + 8, size)
    while True:
        values, vectors = lowest_eigenpairs(hessian, asked, _SHIFT * scale)
        costs = values > _STILL * scale
        if costs.sum() >= count or asked == size:
            break
        asked = min(2 * asked + 6, size)
    still = int((~costs).sum())
    values, vectors = values[costs][:count], vectors[:, costs][:, :count].T
    return values, with_signs(vectors).reshape(len(values), -1, 3), still


def _hessian(places: NDArray[np.float64], cutoff: float):
    """Second derivatives of the springs' energy, (3S, 3S) sparse."""
    from scipy import sparse

    pairs = close_pairs(places, cutoff)
    lines = places[pairs[:, 1]] - places[pairs[:, 0]]
    blocks = lines[:, :, None] * lines[:, None, :] / (lines**2).sum(axis=1)[:, None, None]
    rows, columns, values = [], [], []
    axes = np.arange(3)
    for i, j, sign in ((0, 1, -1), (1, 0, -1), (0, 0, 1), (1, 1, 1)):
        shape = blocks.shape
        rows.append(np.broadcast_to(3 * pairs[:, i, None, None] + axes[:, None], shape).ravel())
        columns.append(np.broadcast_to(3 * pairs[:, j, None, None] + axes, shape).ravel())
        values.append(sign * blocks.ravel())
    size = 3 * len(places)
    entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    return sparse.csc_matrix(entries, shape=(size, size))


def _rotations(places: NDArray[np.float64], shifts: NDArray[np.float64]) -> NDArray[np.float64]:
    """How the surroundings of each site turn: least squares over the sites around. (n, S, 3)"""
    pairs = close_pairs(places, _NEIGHBOURHOOD)
    pairs = np.concatenate([pairs, pairs[:, ::-1]])
    arms = places[pairs[:, 1]] - places[pairs[:, 0]]
    squares = (arms**2).sum(axis=1)
    inertia = squares[:, None, None] * np.eye(3) - arms[:, :, None] * arms[:, None, :]
    total = np.zeros((len(places), 3, 3))
    np.add.at(total, pairs[:, 0], inertia)
    # a site with few others around it turns less
    total += 0.05 * _NEIGHBOURHOOD**2 * np.eye(3)
    moments = np.zeros((len(shifts), len(places), 3))
    for mode, shift in zip(moments, shifts, strict=True):
        relative = shift[pairs[:, 1]] - shift[pairs[:, 0]]
        np.add.at(mode, pairs[:, 0], np.cross(arms, relative))
    return np.linalg.solve(total[None], moments[..., None])[..., 0]


def _overlaps(
    molecule: Molecule,
    other: Molecule,
    sites: NDArray[np.int32],
    vectors: NDArray[np.float64],
) -> tuple[NDArray[np.float64], float]:
    pair = match(molecule, other)
    number = {int(site): k for k, site in enumerate(sites)}
    own = pair.first[pair.sites]
    known = np.array([number[int(atom)] for atom in own])
    here = molecule.positions[own]
    there = _superposed(other.positions[pair.second[pair.sites]], here)
    way = there - here
    parts = vectors[:, known]
    lengths = np.sqrt((parts**2).sum(axis=(1, 2)))
    cosines = np.abs((parts * way).sum(axis=(1, 2))) / np.maximum(
        lengths * np.sqrt((way**2).sum()), 1e-300
    )
    return cosines, float(np.sqrt((way**2).sum(axis=1).mean()) * _ANGSTROM)


def _superposed(moved: NDArray[np.float64], fixed: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points moved as a whole onto others, by least squares (Kabsch)."""
    one, other = moved.mean(axis=0), fixed.mean(axis=0)
    u, _, vt = np.linalg.svd((moved - one).T @ (fixed - other))
    u[:, -1] *= np.sign(np.linalg.det(u @ vt))
    return (moved - one) @ (u @ vt) + other


def write_npz(found: Modes, path: Path) -> None:
    """Arrays by name, for numpy.load."""
    arrays = {
        "eigenvalues": found.eigenvalues,
        "vectors": found.vectors,
        "collectivity": found.collectivity,
        "sites": found.sites,
        "positions_nm": found.molecule.positions[found.sites],
        "cutoff_angstrom": found.cutoff_angstrom,
    }
    if found.overlaps is not None:
        arrays["overlaps"] = found.overlaps
    with open(path, "wb") as file:
        np.savez(file, **arrays)


def write_nmd(found: Modes, path: Path) -> None:
    """NMWiz's text format, which VMD and ProDy read; lengths in angstrom."""
    residues = found.residues()
    atoms = list(found.molecule.topology.atoms())
    places = found.molecule.positions[found.sites] * _ANGSTROM
    lines = [
        "nmwiz_load " + path.name,
        "name " + "_".join(Path(found.molecule.source).name.split()),
        "atomnames " + " ".join(atoms[site].name for site in found.sites),
        "resnames " + " ".join(residue.name for residue in residues),
        "resids " + " ".join(str(residue.id) for residue in residues),
        "chainids " + " ".join(residue.chain.id.strip() or "-" for residue in residues),
        "coordinates " + _numbers(places.ravel(), 3),
    ]
    for k, (value, vector) in enumerate(zip(found.eigenvalues, found.vectors, strict=True)):
        scale = 1 / math.sqrt(value)
        lines.append(f"mode {k + 1} {scale:.6f} {_numbers(vector.ravel(), 5)}")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _numbers(values: Sequence[float], digits: int) -> str:
    return " ".join(f"{value:.{digits}f}" for value in values)


def write_h5(found: Modes, path: Path, force: bool) -> None:
    """The structure as a trajectory of one frame, with the modes among its arrays."""
    from .trajectory import TrajectoryWriter
    from .version import __version__

    molecule = found.molecule
    arrays = {
        "input_positions": molecule.positions,
        "mode_eigenvalues": found.eigenvalues,
        "mode_vectors": found.vectors,
        "mode_collectivity": found.collectivity,
        "mode_sites": found.sites,
    }
    if found.overlaps is not None:
        arrays["mode_overlaps"] = found.overlaps
    with TrajectoryWriter(
        path,
        molecule.topology,
        observables={},
        parameters={"cutoff_angstrom": found.cutoff_angstrom, "count": len(found)},
        attributes={
            "version": __version__,
            "input": molecule.source,
            "input_hash": molecule.source_hash,
        },
        arrays=arrays,
        version=__version__,
        force=force,
    ) as writer:
        writer.append(molecule.positions, 0.0, 0, {})
