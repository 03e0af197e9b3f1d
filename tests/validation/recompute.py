"""Measures a trajectory of ``ragdoll sample`` from the file alone, without any of ragdoll's code.

Lengths in nm, angles in degrees; T frames, N atoms.
"""

import json
from dataclasses import dataclass, field
from pathlib import Path

import h5py
import numpy as np
from scipy.spatial import cKDTree

# centre, then three neighbours whose signed volume tells the hand
_CENTRES = {None: ("CA", "N", "C", "CB"), "THR": ("CB", "CA", "OG1", "CG2")}
_CENTRES["ILE"] = ("CB", "CA", "CG1", "CG2")


@dataclass
class Sampled:
    """What the file holds: frames (T, N, 3), the input (N, 3), bonds (B, 2), and the rest."""

    frames: np.ndarray
    start: np.ndarray
    bonds: np.ndarray
    residues: list[tuple[str, dict[str, int]]]
    framework: dict[str, np.ndarray]
    parameters: dict
    elements: list[str] = field(default_factory=list)


def read(path: str | Path) -> Sampled:
    """Read a trajectory by h5py."""
    with h5py.File(path) as file:
        topology = json.loads(bytes(file["topology"][0]).rstrip(b"\0"))
        residues, elements = [], {}
        for chain in topology["chains"]:
            for residue in chain["residues"]:
                atoms = {atom["name"]: atom["index"] for atom in residue["atoms"]}
                residues.append((residue["name"], atoms))
                elements.update((atom["index"], atom["element"]) for atom in residue["atoms"])
        return Sampled(
            frames=file["coordinates"][:].astype(float),
            start=file["ragdoll/input_positions"][:],
            bonds=np.array(topology["bonds"], dtype=int).reshape(-1, 2),
            residues=residues,
            framework={name: array[()] for name, array in file["ragdoll/framework"].items()},
            parameters=json.loads(file["ragdoll/parameters"].asstr()[()]),
            elements=[elements[index] for index in range(len(elements))],
        )


def bond_deviations(sampled: Sampled) -> np.ndarray:
    """How much bonds differ from the input, relative. (T, B)"""

    def lengths(x):
        return np.linalg.norm(
            x[..., sampled.bonds[:, 1], :] - x[..., sampled.bonds[:, 0], :], axis=-1
        )

    before = lengths(sampled.start)
    return np.abs(lengths(sampled.frames) - before) / before


def omega_atoms(sampled: Sampled, proline: bool = False) -> np.ndarray:
    """CA, C, N, CA of peptide bonds, those before proline only if asked. (n, 4)"""
    donors = {atoms["N"]: (name, atoms) for name, atoms in sampled.residues if "N" in atoms}
    carbons = {atoms["C"]: atoms for _, atoms in sampled.residues if "C" in atoms}
    found = []
    for pair in sampled.bonds.tolist():
        for c, n in (pair, pair[::-1]):
            if c not in carbons or n not in donors or n in carbons[c].values():
                continue
            name, atoms = donors[n]
            if "CA" in carbons[c] and "CA" in atoms and (proline or name != "PRO"):
                found.append((carbons[c]["CA"], c, n, atoms["CA"]))
    return np.array(found, dtype=int).reshape(-1, 4)


def torsions(x: np.ndarray, atoms: np.ndarray) -> np.ndarray:
    """Torsions in degrees; x (..., N, 3), atoms (n, 4)."""
    a, b, c, d = (x[..., atoms[:, k], :] for k in range(4))
    axis = (c - b) / np.linalg.norm(c - b, axis=-1, keepdims=True)
    u = (a - b) - ((a - b) * axis).sum(-1, keepdims=True) * axis
    w = (d - c) - ((d - c) * axis).sum(-1, keepdims=True) * axis
    return np.degrees(np.arctan2((np.cross(axis, u) * w).sum(-1), (u * w).sum(-1)))


def omega_deviations(sampled: Sampled, proline: bool = False) -> np.ndarray:
    """How far peptide torsions turned from the input, degrees. (T, n)"""
    atoms = omega_atoms(sampled, proline)
    turn = torsions(sampled.frames, atoms) - torsions(sampled.start, atoms)
    return np.abs((turn + 180) % 360 - 180)


def chiral_centres(sampled: Sampled) -> np.ndarray:
    """CA of every residue that has CB, and CB of threonine and isoleucine. (n, 4)"""
    return np.array(
        [
            [atoms[name] for name in names]
            for residue, atoms in sampled.residues
            for key, names in _CENTRES.items()
            if key in (None, residue) and all(name in atoms for name in names)
        ],
        dtype=int,
    ).reshape(-1, 4)


def signed_volumes(x: np.ndarray, centres: np.ndarray) -> np.ndarray:
    """Of the three neighbours around each centre. x (..., N, 3), centres (n, 4)"""
    u, v, w = (x[..., centres[:, k], :] - x[..., centres[:, 0], :] for k in (1, 2, 3))
    return (np.cross(u, v) * w).sum(-1)


def inverted(sampled: Sampled) -> int:
    """How many centres have another hand than in the input, over all frames."""
    centres = chiral_centres(sampled)
    same = signed_volumes(sampled.frames, centres) * signed_volumes(sampled.start, centres) > 0
    return int((~same).sum())


def contact_bounds(framework: dict[str, np.ndarray], pairs: np.ndarray) -> np.ndarray:
    """What each pair (n, 2), p < q, must keep apart by the arrays in the file; 0: nothing."""
    radii, polarity = framework["contact_radii"], framework["contact_polarity"]
    scale, heavy, hydrogen = framework["contact_rule"]
    p, q = pairs.T
    kinds = np.sort(np.stack([polarity[p], polarity[q]]), axis=0)
    bounds = scale * (radii[p] + radii[q])
    bounds = bounds - np.where((kinds[0] == 1) & (kinds[1] == 1), heavy, 0)
    bounds = bounds - np.where((kinds[0] == 1) & (kinds[1] == 2), hydrogen, 0)
    bounds = np.where((radii[p] > 0) & (radii[q] > 0), np.maximum(bounds, 0), 0)

    count = len(radii)
    codes = p * count + q

    def code(array):
        return np.sort(array.astype(np.int64), axis=1) @ [count, 1]

    close = code(framework["close_pairs"])
    if len(close):
        order = np.argsort(close)
        place = np.minimum(np.searchsorted(close[order], codes), len(close) - 1)
        hit = close[order][place] == codes
        bounds = np.where(hit, framework["close_pair_lengths"][order][place], bounds)
    return np.where(np.isin(codes, code(framework["contact_exclusions"])), 0, bounds)


def contact_depths(sampled: Sampled, frame: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of a frame that are near, how deep they overlap (nm), and what they should keep."""
    framework = sampled.framework
    if len(framework["contact_radii"]) == 0:
        return np.zeros(0), np.ones(0)
    reach = 2 * framework["contact_rule"][0] * framework["contact_radii"].max()
    pairs = np.sort(cKDTree(frame).query_pairs(reach, output_type="ndarray"), axis=1)
    bounds = contact_bounds(framework, pairs)
    distances = np.linalg.norm(frame[pairs[:, 1]] - frame[pairs[:, 0]], axis=1)
    held = bounds > 0
    return (bounds - distances)[held], bounds[held]


def rmsd(points: np.ndarray, onto: np.ndarray) -> float:
    """After superposition (Kabsch)."""
    a, b = points - points.mean(axis=0), onto - onto.mean(axis=0)
    u, s, vt = np.linalg.svd(a.T @ b)
    s[-1] *= np.sign(np.linalg.det(u @ vt))
    return float(np.sqrt(max(0, (a**2).sum() + (b**2).sum() - 2 * s.sum()) / len(a)))


@dataclass
class Measured:
    """The figures of one trajectory; lengths in angstrom, as ``ragdoll sample --json`` has them."""

    frames: int
    bond_max_relative: float
    omega_max: float  # of non-proline peptides
    omega_max_all: float
    centres: int
    inverted: int
    contact_violations: int
    contact_worst: float
    rmsd: np.ndarray  # of each frame from the input


def measure(sampled: Sampled) -> Measured:
    """Measure all frames."""
    tolerance = sampled.parameters["tolerance"]
    violations, worst = 0, 0.0
    for frame in sampled.frames:
        depths, bounds = contact_depths(sampled, frame)
        violations += int((depths > tolerance * bounds).sum())
        worst = max(worst, depths.max(initial=0))
    return Measured(
        frames=len(sampled.frames),
        bond_max_relative=bond_deviations(sampled).max(initial=0),
        omega_max=omega_deviations(sampled).max(initial=0),
        omega_max_all=omega_deviations(sampled, proline=True).max(initial=0),
        centres=len(chiral_centres(sampled)),
        inverted=inverted(sampled),
        contact_violations=violations,
        contact_worst=10 * worst,
        rmsd=np.array([10 * rmsd(frame, sampled.start) for frame in sampled.frames]),
    )
