"""Quality of frames: stereochemistry, clashes, backbone and bounds, by positions alone."""

import math
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from openmm import unit
from openmm.app import Topology

from . import _core
from .errors import InputError
from .framework import core_molecule
from .molecule import Molecule
from .quality_terms import QualityTerms, quality_terms
from .trajectory import Trajectory, _atomic_numbers_of

_ANGSTROM = 10.0  # per nm
_BLOCK_BYTES = 32 << 20  # of positions that are measured at once

# which way is worse, for the worst frame
_LESS_IS_WORSE = frozenset(("ramachandran_core_percent",))
# means of these are over squares
_ROOTS = frozenset(
    ("bond_rms_angstrom", "angle_rms_degree", "bond_rmsz", "angle_rmsz", "omega_rms_degree")
)

Measures = dict[str, float | int | None]


@dataclass(frozen=True, eq=False, repr=False)
class QualityReport:
    """The quality of frames.

    ``input``, ``mean`` and ``worst`` have one value for each measure, None where it does not apply
    (a nucleic acid has no Ramachandran plot):

    - ``bond_rms_angstrom``, ``bond_max_angstrom``, ``angle_rms_degree``, ``angle_max_degree``:
      bonds and angles between bonds against the input;
    - ``bond_rmsz``, ``angle_rmsz``: of the peptide backbone against Engh and Huber's ideal values,
      in their standard deviations;
    - ``clashes_per_1000``: pairs of heavy atoms that overlap by 0.4 angstrom or more, per 1000
      heavy atoms (radii C 1.70, N 1.55, O 1.52, S 1.80; pairs within four bonds and of two S left
      out; pairs of N and O may overlap by 0.4 angstrom more);
    - ``clash_worst_angstrom``: the deepest of these overlaps, beyond what is allowed;
    - ``all_atom_clashscore``: with hydrogens, like MolProbity's, per 1000 atoms;
    - ``ramachandran_core_percent``, ``ramachandran_outlier_percent``: residues inside the 90 % and
      outside the 99 % contour of MDAnalysis' map; Gly and Pro left out;
    - ``omega_rms_degree``, ``omega_max_degree``, ``omega_over_30_percent``: peptide bonds' turn
      from trans, or from cis where the input is cis;
    - ``inverted_alphas``, ``inverted_centres``: CA atoms, and all centres, of another hand than in
      the input;
    - ``excess_angstrom``: over any upper bound that the file holds, and ``excess_KIND_angstrom``
      for each kind (hydrogen bonds, hydrophobic tethers, ...).

    Attributes:
        input: of the positions that frames are held against.
        mean: over the frames; root mean square for what is an RMS.
        worst: of any frame.
        worst_frame: the frame that has the worst value, from 0.
        frames: of each measure, the value of each frame (n,); NaN where it does not apply.
        counts: how many frames, atoms, heavy_atoms, ramachandran_residues, peptide_bonds, centres,
            and bounds by kind there are.
    """

    input: Measures
    mean: Measures
    worst: Measures
    worst_frame: dict[str, int | None]
    frames: dict[str, NDArray[np.float64]]
    counts: dict[str, Any] = field(default_factory=dict)

    def __len__(self) -> int:
        """Return the number of frames."""
        return self.counts["frames"]

    def __repr__(self) -> str:
        """Return one line."""
        return f"<QualityReport of {len(self)} frame(s)>"

    def as_dict(self) -> dict[str, Any]:
        """Everything but the values of single frames, as plain values."""
        return {
            **self.counts,
            "input": self.input,
            "mean": self.mean,
            "worst": self.worst,
            "worst_frame": self.worst_frame,
        }


def quality(
    source: "Molecule | Trajectory | str | os.PathLike",
    positions: Any = None,
    *,
    framework: Mapping[str, NDArray] | None = None,
) -> QualityReport:
    """Measure the quality of frames, from positions alone.

    Args:
        source: a trajectory or its file, which is measured against the input that it holds (one of
            another program: against its first frame); or a molecule, or its PDB or mmCIF file.
        positions: of a molecule, (n, N, 3) or (N, 3), an OpenMM quantity or numbers in nm; its own
            by default.
        framework: arrays that hold upper bounds: tethers (n, 2), tether_lengths (nm) and
            tether_kinds. A trajectory brings its own.

    Raises:
        InputError: positions do not fit the molecule, or are no numbers.
        TrajectoryError: the file cannot be read.
    """
    if isinstance(source, Trajectory):
        return _of_trajectory(source, framework)
    if isinstance(source, (str, os.PathLike)):
        if Path(source).suffix.lower() in (".h5", ".hdf5"):
            with Trajectory(source) as trajectory:
                return _of_trajectory(trajectory, framework)
        source = Molecule.from_file(source)
    if positions is None:
        positions = source.positions
    if unit.is_quantity(positions):
        positions = positions.value_in_unit(unit.nanometer)
    frames = np.asarray(positions, dtype=np.float64)
    if frames.shape[-2:] != (len(source), 3) or frames.ndim not in (2, 3):
        raise InputError(
            f"The molecule has {len(source)} atoms but the positions have the shape "
            f"{frames.shape}; give (n, {len(source)}, 3) or ({len(source)}, 3)."
        )
    terms = molecule_terms(source, framework)
    return measure(terms, frames.reshape(-1, len(source), 3), source.positions, source.box_vectors)


def molecule_terms(
    molecule: Molecule, framework: Mapping[str, NDArray] | None = None
) -> QualityTerms:
    """What is to be measured of a molecule."""
    return quality_terms(core_molecule(molecule), molecule.topology, molecule.bonds, framework)


def _of_trajectory(
    trajectory: Trajectory, framework: Mapping[str, NDArray] | None
) -> QualityReport:
    topology = trajectory.topology
    if topology is None or len(trajectory) == 0:
        what = "no topology" if topology is None else "no frames"
        raise InputError(f"{trajectory.path} holds {what}, so that nothing can be measured.")
    start = trajectory.arrays.get("input_positions")
    if start is None:
        start = trajectory.frame(0).positions
    start = np.asarray(start, dtype=np.float64)
    bonds = trajectory.bonds
    try:
        molecule = _file_molecule(topology, bonds, start)
    except ValueError as error:
        raise InputError(f"{trajectory.path}: {error}.") from None
    if framework is None:
        framework = trajectory.framework
    terms = quality_terms(molecule, topology, bonds, framework)
    if trajectory.boxes is None:
        return measure(terms, _blocks(trajectory), start)
    boxed = ((frame.positions[None], frame.box) for frame in trajectory)
    return measure(terms, boxed, start, trajectory.boxes[0])


def _file_molecule(
    topology: Topology, bonds: NDArray[np.integer], start: NDArray[np.float64]
) -> _core.Molecule:
    """The atoms of a trajectory file as core sees them."""
    orders = {}
    for bond in topology.bonds():
        key = frozenset((bond[0].index, bond[1].index))
        kind = getattr(bond.type, "__name__", None) or str(bond.type)
        orders[key] = 4 if kind == "Aromatic" else (bond.order or 0)
    pairs = np.sort(np.asarray(bonds, dtype=np.int32), axis=1)
    return _core.Molecule(
        _atomic_numbers_of(topology),
        np.array([atom.formalCharge or 0 for atom in topology.atoms()], dtype=np.int32),
        np.ones(len(start)),
        start,
        pairs,
        np.array([min(orders.get(frozenset(p), 0), 4) for p in pairs.tolist()], dtype=np.uint8),
    )


def _blocks(trajectory: Trajectory) -> Iterable[tuple[NDArray, None]]:
    atoms = trajectory.atom_count
    step = max(1, _BLOCK_BYTES // (24 * atoms))
    for first in range(0, len(trajectory), step):
        count = min(step, len(trajectory) - first)
        yield trajectory._reader.positions(first, count), None


def measure(
    terms: QualityTerms,
    frames: "NDArray[np.float64] | Iterable[tuple[NDArray, NDArray | None]]",
    start: NDArray[np.float64],
    box: NDArray[np.float64] | None = None,
) -> QualityReport:
    """Measure frames.

    Args:
        terms: what is measured.
        frames: (n, N, 3) in nm; or in parts, each with its box (3, 3) or None.
        start: what they are held against, (N, 3) in nm.
        box: of ``start``, and of all frames where these are one array.

    Raises:
        InputError: a frame has a coordinate that is no number.
    """
    parts = [(frames, box)] if isinstance(frames, np.ndarray) else frames
    measured = []
    try:
        first = terms.check.measure(start[None], box)
        for block, of_block in parts:
            measured.append(terms.check.measure(block.astype(np.float64), of_block))
    except ValueError as error:
        raise InputError(f"Quality cannot be measured: {error}.") from None
    columns = {name: np.concatenate([part[name] for part in measured]) for name in first}
    own = {name: float(values[0]) for name, values in _figures(terms, first, len(start)).items()}
    all_frames = _figures(terms, columns, len(start))
    worst_frame = {name: _worst(name, values) for name, values in all_frames.items()}
    return QualityReport(
        input={name: _plain(value, name) for name, value in own.items()},
        mean={
            name: _plain(_mean(name, values), name, mean=True)
            for name, values in all_frames.items()
        },
        worst={
            name: None if (k := worst_frame[name]) is None else _plain(values[k], name)
            for name, values in all_frames.items()
        },
        worst_frame=worst_frame,
        frames=all_frames,
        counts={
            "frames": len(columns["bond_rms"]),
            "atoms": len(start),
            "heavy_atoms": terms.check.heavy_count,
            "peptide_bonds": terms.peptide_bonds,
            "ramachandran_residues": terms.residues,
            "centres": terms.check.centre_count,
            "bounds": terms.bounds,
        },
    )


def _figures(
    terms: QualityTerms, columns: Mapping[str, NDArray], atoms: int
) -> dict[str, NDArray[np.float64]]:
    """The measures of frames by name, NaN where they do not apply. (n,) each"""

    def of(applies: Any, values: NDArray) -> NDArray[np.float64]:
        return values.astype(np.float64) if applies else np.full(len(values), np.nan)

    heavy = max(terms.check.heavy_count, 1)
    residues, omegas = terms.residues or 0, terms.peptide_bonds
    figures = {
        "bond_rms_angstrom": columns["bond_rms"] * _ANGSTROM,
        "bond_max_angstrom": columns["bond_max"] * _ANGSTROM,
        "angle_rms_degree": columns["angle_rms"],
        "angle_max_degree": columns["angle_max"],
        "bond_rmsz": of(terms.ideal, columns["bond_rmsz"]),
        "angle_rmsz": of(terms.ideal, columns["angle_rmsz"]),
        "clashes_per_1000": 1000 * columns["clashes"] / heavy,
        "clash_worst_angstrom": columns["clash_worst"] * _ANGSTROM,
        "all_atom_clashscore": of(heavy < atoms, 1000 * columns["all_atom_clashes"] / atoms),
        "ramachandran_core_percent": of(residues, 100 * columns["core"] / max(residues, 1)),
        "ramachandran_outlier_percent": of(residues, 100 * columns["outliers"] / max(residues, 1)),
        "omega_rms_degree": of(omegas, columns["omega_rms"]),
        "omega_max_degree": of(omegas, columns["omega_max"]),
        "omega_over_30_percent": of(omegas, 100 * columns["omegas_off"] / max(omegas, 1)),
        "inverted_alphas": of(omegas, columns["alphas_inverted"]),
        "inverted_centres": of(terms.check.centre_count, columns["centres_inverted"]),
    }
    excess = columns["excess"] * _ANGSTROM
    figures["excess_angstrom"] = (
        excess.max(axis=1) if terms.bounds else np.full(len(excess), np.nan)
    )
    for k, kind in enumerate(terms.bounds):
        figures[f"excess_{kind}_angstrom"] = excess[:, k]
    return figures


def _mean(name: str, values: NDArray[np.float64]) -> float:
    if len(values) == 0:
        return math.nan
    return float(np.sqrt(np.mean(values**2)) if name in _ROOTS else values.mean())


def _worst(name: str, values: NDArray[np.float64]) -> int | None:
    if len(values) == 0 or np.isnan(values).any():
        return None
    return int(values.argmin() if name in _LESS_IS_WORSE else values.argmax())


def _plain(value: float, name: str, mean: bool = False) -> float | int | None:
    if math.isnan(value):
        return None
    counted = name in ("inverted_alphas", "inverted_centres") and not mean
    return int(value) if counted else float(value)
