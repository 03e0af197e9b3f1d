"""What in a molecule can move: the pebble game over its bonds, at one cutoff or at all."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from .bond_lists import BondLists, RigidityOptions, find_bonds, named
from .errors import InputError
from .molecule import Molecule
from .residue_match import residue_label
from .sites import ligands_of


@dataclass(frozen=True, eq=False, repr=False)
class NetworkRigidity:
    """The rigidity of a network of bodies and bonds.

    Attributes:
        degrees_of_freedom: those of each separate body's place and turn included.
        floppy_modes: without these six of each separate body.
        separate_bodies: that no bond joins.
        redundant_bars: bars that change nothing.
        cluster_of_body: (N,) rigid cluster of each body; cluster 0 is the largest.
        cluster_sizes: bodies in each cluster, the largest first.
        region_of_body: (N,) over-constrained region of each body, -1 elsewhere.
        region_sizes: bodies in each region, the largest first.
        hinges: bonds of five bars between clusters, as indices.
        hinge_groups: hinges that turn together, as (freedoms, indices of bonds).
        inner_bodies: (N,) whether a body has more than one bond.
    """

    degrees_of_freedom: int
    floppy_modes: int
    separate_bodies: int
    redundant_bars: int
    cluster_of_body: NDArray[np.int32]
    cluster_sizes: NDArray[np.int32]
    region_of_body: NDArray[np.int32]
    region_sizes: NDArray[np.int32]
    hinges: NDArray[np.int32]
    hinge_groups: list[tuple[int, NDArray[np.int32]]]
    inner_bodies: NDArray[np.bool_]

    @property
    def largest_cluster(self) -> int:
        """Bodies in the largest cluster."""
        return int(self.cluster_sizes[0])

    @property
    def largest_cluster_inner(self) -> int:
        """Those of them that have more than one bond, which is how other programs count."""
        return int((self.inner_bodies & (self.cluster_of_body == 0)).sum())

    def counts(self) -> dict[str, Any]:
        """The figures, as plain values."""
        return {
            "degrees_of_freedom": self.degrees_of_freedom,
            "floppy_modes": self.floppy_modes,
            "separate_bodies": self.separate_bodies,
            "rigid_clusters": self.cluster_sizes.tolist(),
            "largest_cluster": self.largest_cluster,
            "largest_cluster_inner": self.largest_cluster_inner,
            "hinges": len(self.hinges),
            "redundant_bars": self.redundant_bars,
        }


def network_rigidity(
    bodies: int,
    bonds: Sequence[Sequence[int]] | NDArray[np.integer],
    bars: Sequence[int] | NDArray[np.integer],
    *,
    lock_leaves: bool = True,
) -> NetworkRigidity:
    """The pebble game on a list of bonds, such as another program's.

    Args:
        bodies: how many there are, such as atoms.
        bonds: (n, 2) bodies, counted from 0.
        bars: (n,) bars of each bond, 1 to 6; a bond that turns has 5.
        lock_leaves: a bond of 5 bars has 6 where one of its ends has no other bond, since the spin
            of an atom about its only bond is no motion.

    Raises:
        InputError: a bond makes no sense.
    """
    game = _NetworkDilution(bodies, bonds, bars, None, lock_leaves)
    return game.at(0, groups=True)


class _NetworkDilution:
    """core's Dilution with results as NetworkRigidity."""

    def __init__(self, bodies, bonds, bars, fixed_bonds=None, lock_leaves=True):
        ends = np.ascontiguousarray(bonds, dtype=np.int32).reshape(-1, 2)
        bars = np.ascontiguousarray(bars, dtype=np.int32)
        self._bodies, self._ends = bodies, ends
        self._fixed = len(ends) if fixed_bonds is None else fixed_bonds
        try:
            self._core = _core.Dilution(bodies, ends, bars, self._fixed, lock_leaves)
        except ValueError as error:
            text = str(error)
            raise InputError(f"{text[0].upper()}{text[1:]}.") from None

    def at(self, level: int, *, groups: bool) -> NetworkRigidity:
        """The rigidity with so many of the bonds that are not fixed."""
        ends = self._ends[: self._fixed + level]
        inner = np.bincount(ends.ravel(), minlength=self._bodies) > 1
        return NetworkRigidity(**self._core.at(level, groups), inner_bodies=inner)


@dataclass(frozen=True, eq=False, repr=False)
class RigidityResult(NetworkRigidity):
    """The rigidity of a molecule; its bodies are the atoms.

    Attributes:
        molecule: what was looked at.
        options: how.
        bonds: all bonds that counted.
        notes: sentences on what was left out.
    """

    molecule: Molecule
    options: RigidityOptions
    bonds: BondLists
    notes: list[str] = field(default_factory=list)

    def __repr__(self) -> str:
        """Return one line; the arrays would fill pages."""
        return (
            f"<RigidityResult {self.molecule.source}: {self.floppy_modes} floppy modes, "
            f"{len(self.cluster_sizes)} rigid clusters>"
        )

    def _ligands(self) -> list[dict[str, Any]]:
        """Each ligand: its atoms, the clusters they are in, and what holds it to the rest."""
        found = []
        for residue in ligands_of(self.molecule.topology):
            atoms = [atom.index for atom in residue.atoms()]

            def across(pairs: NDArray[np.int32], atoms: list[int] = atoms) -> NDArray[np.intp]:
                return np.flatnonzero(np.isin(pairs, atoms).sum(axis=1) == 1)

            found.append(
                {
                    "residue": residue_label(residue),
                    "atoms": atoms,
                    "clusters": np.unique(self.cluster_of_body[atoms]).tolist(),
                    "hydrogen_bonds": across(self.bonds.hbonds[:, 1:]).tolist(),
                    "tethers": across(self.bonds.tethers).tolist(),
                    "covalent_bonds": len(across(self.bonds.covalent)),
                }
            )
        return found

    def as_dict(self) -> dict[str, Any]:
        """Everything as plain values; atoms are counted from 0 in the molecule's order."""
        bonds, labels = self.bonds, self.molecule.labels
        ends = bonds.ends
        regions = np.flatnonzero(self.region_of_body >= 0)
        return {
            "source": self.molecule.source,
            "source_hash": self.molecule.source_hash,
            "atoms": len(self.molecule),
            "covalent_bonds": len(bonds.covalent),
            "locked_bonds": int(bonds.locked.sum()),
            "hydrogen_bonds": len(bonds.hbonds),
            "salt_bridges": int(bonds.salt_bridge.sum()),
            "tethers": len(bonds.tethers),
            "fixed_atoms": len(bonds.body) + 1 if len(bonds.body) else 0,
            **self.counts(),
            "cluster_of_atom": self.cluster_of_body.tolist(),
            "over_constrained_regions": self.region_sizes.tolist(),
            "over_constrained_atoms": regions.tolist(),
            "hydrogen_bond_list": bonds.hbond_list(labels),
            "tether_list": bonds.tether_list(labels),
            "ligands": self._ligands(),
            "hinge_list": [named(ends[k], labels) for k in self.hinges],
            "hinge_groups": [
                {"freedoms": freedoms, "hinges": [ends[k].tolist() for k in hinges]}
                for freedoms, hinges in self.hinge_groups
                if len(hinges) > 1
            ],
            "parameters": self.options.as_dict(),
            "notes": self.notes,
        }


@dataclass(frozen=True, eq=False, repr=False)
class DilutionResult:
    """The rigidity of a molecule at every number of its hydrogen bonds.

    Attributes:
        molecule: what was looked at.
        options: how; the cutoff is that of the weakest bond.
        bonds: all bonds that counted, hydrogen bonds strongest first.
        levels: how many hydrogen bonds each level has, from all of them down to none.
        cutoffs_kcal: (levels,) energy of the weakest bond of each level; NaN without bonds.
        notes: sentences on what was left out.
    """

    molecule: Molecule
    options: RigidityOptions
    bonds: BondLists
    levels: NDArray[np.int64]
    cutoffs_kcal: NDArray[np.float64]
    notes: list[str]
    _game: _NetworkDilution

    def __len__(self) -> int:
        """Return the number of levels."""
        return len(self.levels)

    def __repr__(self) -> str:
        """Return one line."""
        return f"<DilutionResult {self.molecule.source}: {len(self)} levels>"

    def at(self, index: int) -> NetworkRigidity:
        """The rigidity of a level, without hinge groups."""
        return self._game.at(int(self.levels[index]), groups=False)

    def as_dict(self) -> dict[str, Any]:
        """Everything as plain values, one entry for each cutoff."""
        bonds, labels = self.bonds, self.molecule.labels
        entries = []
        for index, (count, cutoff) in enumerate(zip(self.levels, self.cutoffs_kcal, strict=True)):
            level = self.at(index)
            entries.append(
                {
                    "hbond_cutoff_kcal": None if math.isnan(cutoff) else float(cutoff),
                    "hydrogen_bonds": int(count),
                    "salt_bridges": int(bonds.salt_bridge[:count].sum()),
                    **level.counts(),
                    "over_constrained_atoms": int((level.region_of_body >= 0).sum()),
                }
            )
        return {
            "source": self.molecule.source,
            "source_hash": self.molecule.source_hash,
            "atoms": len(self.molecule),
            "covalent_bonds": len(bonds.covalent),
            "locked_bonds": int(bonds.locked.sum()),
            "hydrogen_bonds": len(bonds.hbonds),
            "salt_bridges": int(bonds.salt_bridge.sum()),
            "tethers": len(bonds.tethers),
            "dilution": entries,
            "hydrogen_bond_list": bonds.hbond_list(labels),
            "tether_list": bonds.tether_list(labels),
            "parameters": self.options.as_dict(),
            "notes": self.notes,
        }


def rigidity(
    molecule: Molecule, options: RigidityOptions | None = None, **values: Any
) -> RigidityResult:
    """Rigid clusters, hinges and floppy modes of a molecule, by the pebble game.

    Args:
        molecule: with its hydrogens.
        options: what counts as a bond; the defaults are those of ProFlex.
        values: fields of RigidityOptions, such as ``hbond_cutoff_kcal=-2.0``, over ``options``.

    Raises:
        InputError: the molecule has no hydrogens, or an option is out of range.
    """
    options = _options(options, values)
    bonds, notes = find_bonds(molecule, options)
    game = _NetworkDilution(len(molecule), bonds.ends, bonds.bars)
    found = game.at(0, groups=True)
    return RigidityResult(
        **vars(found), molecule=molecule, options=options, bonds=bonds, notes=notes
    )


def dilution(
    molecule: Molecule,
    options: RigidityOptions | None = None,
    *,
    cutoffs_kcal: Iterable[float] | None = None,
    **values: Any,
) -> DilutionResult:
    """The rigidity at every cutoff, in one pass: hydrogen bonds go one by one, the weakest first.

    Args:
        molecule: with its hydrogens.
        options: what counts as a bond; its cutoff is that of the weakest hydrogen bond, by default
            -0.1 kcal/mol.
        cutoffs_kcal: only these; by default the energy of each hydrogen bond, and none at all.
        values: fields of RigidityOptions, over ``options``.

    Raises:
        InputError: the molecule has no hydrogens, or an option is out of range.
    """
    if options is None and "hbond_cutoff_kcal" not in values:
        values["hbond_cutoff_kcal"] = -0.1
        if cutoffs_kcal is not None:
            cutoffs_kcal = [float(cutoff) for cutoff in cutoffs_kcal]
            values["hbond_cutoff_kcal"] = max(cutoffs_kcal, default=-0.1)
    options = _options(options, values)
    bonds, notes = find_bonds(molecule, options)
    if cutoffs_kcal is None:
        levels = np.arange(len(bonds.hbonds), -1, -1)
        cutoffs = np.append(bonds.hbond_kcal[::-1], np.nan)
    else:
        cutoffs = np.sort(np.array(list(cutoffs_kcal), dtype=np.float64))[::-1]
        if not np.isfinite(cutoffs).all() or (cutoffs > options.hbond_cutoff_kcal).any():
            raise InputError(
                "Cutoffs of a dilution must be numbers up to hbond_cutoff_kcal, which is "
                f"{options.hbond_cutoff_kcal:g}."
            )
        levels = np.searchsorted(bonds.hbond_kcal, cutoffs, side="right")
    game = _NetworkDilution(
        len(molecule), bonds.ends, bonds.bars, len(bonds.bars) - len(bonds.hbonds)
    )
    return DilutionResult(molecule, options, bonds, levels, cutoffs, notes, game)


def _options(options: RigidityOptions | None, values: dict[str, Any]) -> RigidityOptions:
    fields = dict(vars(options or RigidityOptions()))
    unknown = values.keys() - fields.keys()
    if unknown:
        raise TypeError(f"there is no option {', '.join(sorted(unknown))}")
    options = RigidityOptions(**{**fields, **values})
    options.check()
    return options
