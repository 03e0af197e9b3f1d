"""The bonds of a molecule that rigidity counts: covalent, hydrogen bonds, hydrophobic tethers."""

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from .errors import InputError
from .framework import core_molecule
from .molecule import Molecule
from .residue_match import residue_label
from .selection import is_solvent
from .user_constraints import UserConstraint, fixed_atoms

_KCAL = _core.KILOJOULE_PER_KILOCALORIE
_ANGSTROM = 10.0  # per nm
_LOCKS = ("peptide", "guanidinium", "multiple", "aromatic", "primary_amide")


@dataclass(frozen=True)
class RigidityOptions:
    """What counts as a bond, and with how many bars.

    Attributes:
        hbond_cutoff_kcal: hydrogen bonds and salt bridges at least this strong count, kcal/mol.
        hbond_angstrom: the most between hydrogen and acceptor; sulfur and salt bridges reach
            further by 0.5 and 1.0 angstrom.
        hbond_angle_degree: the least angle of donor, hydrogen and acceptor.
        tether_angstrom: the most between the surfaces of two non-polar atoms; negative: no tethers.
        hbond_bars: bars of a hydrogen bond, of 6.
        tether_bars: bars of a hydrophobic tether, of 6.
        locks: which covalent bonds do not turn, of peptide, guanidinium, multiple, aromatic and
            primary_amide.
        solvent_hbonds: whether waters that are kept take part in hydrogen bonds.
        fixed: entries "fix" and "move": the atoms that they fix are one rigid body.
    """

    hbond_cutoff_kcal: float = -1.0
    hbond_angstrom: float = 2.5
    hbond_angle_degree: float = 110.0
    tether_angstrom: float = 0.5
    hbond_bars: int = 5
    tether_bars: int = 2
    locks: tuple[str, ...] = _LOCKS[:4]
    solvent_hbonds: bool = False
    fixed: tuple[UserConstraint, ...] = ()

    def check(self) -> None:
        """Refuse what makes no sense.

        Raises:
            InputError: a value is out of range; the message names it.
        """
        numbers = (
            ("hbond_cutoff_kcal", "kcal/mol, from -100 to 0", -100, 0),
            ("hbond_angstrom", "angstrom, from 1 to 5", 1, 5),
            ("hbond_angle_degree", "degrees, from 0 to 180", 0, 180),
            ("tether_angstrom", "angstrom, up to 5; negative for no tethers", -math.inf, 5),
        )
        for name, meaning, low, high in numbers:
            value = getattr(self, name)
            if not math.isfinite(value) or not low <= value <= high:
                raise InputError(f"{name} must be a number of {meaning}, not {value}.")
        for name in ("hbond_bars", "tether_bars"):
            if getattr(self, name) not in range(1, 7):
                raise InputError(f"{name} must be from 1 to 6, not {getattr(self, name)}.")
        for lock in self.locks:
            if lock not in _LOCKS:
                raise InputError(f"There is no lock '{lock}'; locks are {', '.join(_LOCKS)}.")

    def as_dict(self) -> dict[str, Any]:
        """The options as plain values."""
        return {**asdict(self), "locks": list(self.locks)}


@dataclass(frozen=True, eq=False, repr=False)
class BondLists:
    """The bonds of a molecule that rigidity counts.

    Attributes:
        covalent: (B, 2) atoms.
        locked: (B,) whether a covalent bond does not turn.
        tethers: (T, 2) atoms.
        tether_angstrom: (T,) their distances.
        hbonds: (H, 3) donor, hydrogen and acceptor, the strongest first.
        hbond_kcal: (H,) energies.
        hbond_angstrom: (H,) distances of hydrogen and acceptor.
        hbond_angle_degree: (H,) angles of donor, hydrogen and acceptor.
        salt_bridge: (H,) whether it is a salt bridge.
        body: (F, 2) the first fixed atom with each other one; these make one body of them.
        bars: (B + F + T + H,) bars of covalent bonds, of the body, of tethers and hydrogen bonds.
    """

    covalent: NDArray[np.int32]
    locked: NDArray[np.bool_]
    tethers: NDArray[np.int32]
    tether_angstrom: NDArray[np.float64]
    hbonds: NDArray[np.int32]
    hbond_kcal: NDArray[np.float64]
    hbond_angstrom: NDArray[np.float64]
    hbond_angle_degree: NDArray[np.float64]
    salt_bridge: NDArray[np.bool_]
    body: NDArray[np.int32]
    bars: NDArray[np.int32]

    @property
    def ends(self) -> NDArray[np.int32]:
        """(B + F + T + H, 2) atoms of all bonds; of hydrogen bonds hydrogen and acceptor."""
        return np.concatenate([self.covalent, self.body, self.tethers, self.hbonds[:, 1:]])

    def hbond_list(self, labels: list[str]) -> list[dict[str, Any]]:
        """The hydrogen bonds as plain values."""
        return [
            {
                **named(atoms, labels),
                "energy_kcal": float(self.hbond_kcal[k]),
                "hydrogen_acceptor_angstrom": float(self.hbond_angstrom[k]),
                "angle_degree": float(self.hbond_angle_degree[k]),
                "salt_bridge": bool(self.salt_bridge[k]),
            }
            for k, atoms in enumerate(self.hbonds)
        ]

    def tether_list(self, labels: list[str]) -> list[dict[str, Any]]:
        """The tethers as plain values."""
        return [
            {**named(atoms, labels), "distance_angstrom": float(distance)}
            for atoms, distance in zip(self.tethers, self.tether_angstrom, strict=True)
        ]


def named(atoms: NDArray[np.int32], labels: list[str]) -> dict[str, Any]:
    """Atoms by number and name, as plain values."""
    return {"atoms": atoms.tolist(), "names": [labels[atom] for atom in atoms]}


def find_bonds(molecule: Molecule, options: RigidityOptions) -> tuple[BondLists, list[str]]:
    """The bonds that rigidity counts, and notes on what was left out.

    Raises:
        InputError: the molecule has no hydrogens.
    """
    name = molecule.source or "The molecule"
    if not (molecule.elements == 1).any():
        raise InputError(
            f"{name} has no hydrogens, without which there are no hydrogen bonds; "
            "add them (--add-hydrogens, or Molecule.from_file(..., add_hydrogens=True))."
        )
    core = core_molecule(molecule)
    found = _core.hydrogen_bonds(
        core,
        weakest=options.hbond_cutoff_kcal * _KCAL,
        hydrogen_acceptor=options.hbond_angstrom / _ANGSTROM,
        donor_acceptor=(options.hbond_angstrom + 1.0) / _ANGSTROM,
        least_angle_degree=options.hbond_angle_degree,
    )
    counts = np.ones(len(found["energies"]), dtype=bool)
    notes = _bare_residues(molecule)
    if not options.solvent_hbonds:
        solvent = np.zeros(len(molecule), dtype=bool)
        for residue in molecule.topology.residues():
            if is_solvent(residue):
                solvent[[atom.index for atom in residue.atoms()]] = True
        counts = ~solvent[found["atoms"]].any(axis=1)
        if not counts.all():
            notes.append(f"Hydrogen bonds of waters were left out: {int((~counts).sum())}.")
    hbonds = np.ascontiguousarray(found["atoms"][counts])
    tethers = {"atoms": np.empty((0, 2), dtype=np.int32), "distances": np.empty(0)}
    if options.tether_angstrom >= 0:
        tethers = _core.hydrophobic_tethers(
            core, margin=options.tether_angstrom / _ANGSTROM, shortest=0.22
        )
    network = _core.bond_network(
        core,
        tethers["atoms"],
        np.ascontiguousarray(hbonds[:, 1:]),
        locks=list(options.locks),
        hydrogen_bond_bars=options.hbond_bars,
        tether_bars=options.tether_bars,
    )
    covalent = network["ends"][: len(molecule.bonds)]
    fixed = fixed_atoms(molecule, options.fixed) if options.fixed else []
    body = np.array([(fixed[0], atom) for atom in fixed[1:]], dtype=np.int32).reshape(-1, 2)
    bars = np.insert(network["bars"], len(covalent), np.full(len(body), 6, dtype=np.int32))
    lists = BondLists(
        covalent=covalent,
        locked=network["bars"][: len(covalent)] == 6,
        tethers=tethers["atoms"],
        tether_angstrom=tethers["distances"] * _ANGSTROM,
        hbonds=hbonds,
        hbond_kcal=found["energies"][counts] / _KCAL,
        hbond_angstrom=found["hydrogen_acceptor"][counts] * _ANGSTROM,
        hbond_angle_degree=found["angles_degree"][counts],
        salt_bridge=found["salt_bridge"][counts].astype(bool),
        body=body,
        bars=bars.astype(np.int32),
    )
    return lists, notes


def _bare_residues(molecule: Molecule) -> list[str]:
    """A note on residues that should have hydrogens and have none."""
    bare = []
    for residue in molecule.topology.residues():
        symbols = [atom.element.symbol for atom in residue.atoms()]
        # PRO has no hydrogen on N; files with polar hydrogens alone are whole without
        if len(symbols) > 3 and "H" not in symbols and "N" in symbols and residue.name != "PRO":
            bare.append(residue_label(residue))
    if not bare:
        return []
    names = ", ".join(bare[:3]) + (" and others" if len(bare) > 3 else "")
    return [f"Residues without hydrogens, which give no hydrogen bonds: {len(bare)}, {names}."]
