"""A molecule as the rest of ragdoll sees it: atoms, bonds and their places."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from openmm import unit
from openmm.app import Topology
from rdkit import Chem

from .errors import InputError
from .hydrogens import add_hydrogens as place_hydrogens
from .perception import perceive
from .polar_hydrogens import turn_polar_hydrogens
from .rdkit_molecule import read_rdkit
from .residue_match import MissingAtoms, residue_label
from .selection import atoms_to_keep, check_atoms, copy_topology
from .structure_file import read_structure_file
from .topology_bonds import add_bonds, given_bonds

_ANGSTROM = 10.0  # per nm


@dataclass(frozen=True, eq=False, repr=False)
class Molecule:
    """Atoms with places and bonds; never changed once made.

    Attributes:
        topology: OpenMM topology of exactly these atoms in this order, with bonds.
        positions: (N, 3) float64 in nm.
        elements: (N,) int32 atomic numbers.
        charges: (N,) int32 formal charges.
        masses: (N,) float64 in dalton.
        bonds: (B, 2) int32 atom indices, the smaller first, each pair once.
        bond_orders: (B,) uint8: 0 unknown, 1 single, 2 double, 3 triple, 4 aromatic, 5 dative.
        labels: name of each atom for messages, such as "CA GLY45 A".
        missing_atoms: heavy atoms that standard residues lack.
        notes: sentences on what was left out or could not be told.
        source: path of the file, or what else the molecule was made from.
        source_hash: SHA-256, hexadecimal, of the file's bytes, or of the atoms without a file.
        box_vectors: (3, 3) in nm, or None without a periodic box; given only with solvent.
        b_factors: (N,) in square angstrom, or None.
    """

    topology: Topology
    positions: NDArray[np.float64]
    elements: NDArray[np.int32]
    charges: NDArray[np.int32]
    masses: NDArray[np.float64]
    bonds: NDArray[np.int32]
    bond_orders: NDArray[np.uint8]
    labels: list[str]
    missing_atoms: list[MissingAtoms] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    source: str = ""
    source_hash: str = ""
    box_vectors: NDArray[np.float64] | None = None
    b_factors: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    def __len__(self) -> int:
        """Return the number of atoms."""
        return len(self.elements)

    def __repr__(self) -> str:
        """Return one line; the arrays would fill pages."""
        return f"<Molecule {self.source}: {len(self)} atoms, {len(self.bonds)} bonds>"

    @classmethod
    def from_file(
        cls,
        path: str | Path,
        *,
        model: int = 1,
        altloc: str | None = None,
        chains: Sequence[str] | None = None,
        keep_solvent: bool = False,
        add_hydrogens: bool = False,
        ph: float = 7.0,
    ) -> "Molecule":
        """Read a protein, nucleic acid or complex from a PDB or mmCIF file, plain or gzipped.

        Args:
            path: the file.
            model: which model, counted from 1.
            altloc: alternate location to keep where a residue has it; each residue's first by
                default.
            chains: ids of the chains to keep; all by default.
            keep_solvent: keep waters and single ions, and the unit cell.
            add_hydrogens: add the hydrogens that standard residues lack.
            ph: decides which hydrogens those are.

        Raises:
            InputError: the file or an option cannot be used; the message says why.
        """
        file = read_structure_file(path, model=model, altloc=altloc, chains=chains)
        keep, notes = atoms_to_keep(file.topology, keep_solvent, str(path))
        number = np.cumsum(keep) - 1
        recorded = file.recorded_bonds[keep[file.recorded_bonds].all(axis=1)]
        return cls._from_atoms(
            copy_topology(file.topology, keep),
            file.positions[keep],
            given={},
            recorded=number[recorded],
            stated_charges=file.charges[keep],
            hydrogens_at_ph=ph if add_hydrogens else None,
            notes=file.notes + notes,
            source=str(path),
            source_hash=file.source_hash,
            box_vectors=file.box_vectors if keep_solvent else None,
            b_factors=file.b_factors[keep],
        )

    @classmethod
    def from_topology(
        cls, topology: Topology, positions: Any, *, keep_solvent: bool = False
    ) -> "Molecule":
        """Take the molecule that an OpenMM topology describes.

        A residue that has bonds in the topology keeps them and gets no others; one without gets
        them from its template or by distance. Orders that bonds lack are found.

        Args:
            topology: chains, residues, atoms and bonds.
            positions: (N, 3), an OpenMM quantity or numbers in nm.
            keep_solvent: keep waters and single ions, and the box; by default they are left out.

        Raises:
            InputError: positions do not fit the topology, or atoms cannot be used.
        """
        if unit.is_quantity(positions):
            positions = positions.value_in_unit(unit.nanometer)
        places = np.array(positions, dtype=np.float64)
        if places.shape != (topology.getNumAtoms(), 3):
            raise InputError(
                f"The topology has {topology.getNumAtoms()} atoms but the positions have the shape "
                f"{places.shape}; give one place for each atom."
            )
        keep, notes = atoms_to_keep(topology, keep_solvent, "The topology")
        number = np.cumsum(keep) - 1
        given = {
            (int(number[i]), int(number[j])): order
            for (i, j), order in given_bonds(topology).items()
            if keep[i] and keep[j]
        }
        stated = [atom.formalCharge or 0 for atom in topology.atoms()]
        box = topology.getPeriodicBoxVectors() if keep_solvent else None
        return cls._from_atoms(
            copy_topology(topology, keep),
            places[keep],
            given=given,
            recorded=np.empty((0, 2), dtype=np.int64),
            stated_charges=np.array(stated, dtype=np.int32)[keep],
            notes=notes,
            source="The topology",
            box_vectors=None if box is None else np.array(box.value_in_unit(unit.nanometer)),
        )

    @classmethod
    def from_rdkit(cls, mol: Chem.Mol, conformer: int = -1) -> "Molecule":
        """Take the explicit atoms, bonds, aromaticity and charges of an RDKit molecule.

        Args:
            mol: with a conformer in three dimensions.
            conformer: id of the conformer; -1 is the first.

        Raises:
            InputError: there is no such conformer, it is flat, or an atom has no element.
        """
        found = read_rdkit(mol, conformer)
        topology = found.topology
        check_atoms(topology, found.positions, found.source)
        add_bonds(topology, found.bonds, found.bond_orders)
        return cls(
            charges=found.charges,
            bonds=found.bonds,
            bond_orders=found.bond_orders,
            notes=found.notes,
            source=found.source,
            positions=found.positions,
            **{**_derived(topology), "masses": found.masses},
            source_hash=_hash(found.positions, found.charges, found.bonds, found.bond_orders),
        )

    @classmethod
    def _from_atoms(
        cls,
        topology: Topology,
        positions: NDArray[np.float64],
        *,
        given: dict[tuple[int, int], int],
        recorded: NDArray[np.int64],
        stated_charges: NDArray[np.int32],
        notes: list[str],
        source: str,
        source_hash: str = "",
        hydrogens_at_ph: float | None = None,
        box_vectors: NDArray[np.float64] | None = None,
        b_factors: NDArray[np.float64] | None = None,
    ) -> "Molecule":
        check_atoms(topology, positions, source)
        perception = perceive(topology, positions * _ANGSTROM, given, recorded)
        if hydrogens_at_ph is not None:
            add_bonds(topology, perception.bonds, perception.bond_orders)
            topology, positions, origin, more = place_hydrogens(
                topology, positions, hydrogens_at_ph
            )
            notes = notes + more
            first = np.unique(origin, return_index=True)[1]
            perception = perceive(topology, positions * _ANGSTROM, {}, first[recorded])
            is_old = np.zeros(len(origin), dtype=bool)
            is_old[first] = True
            stated_charges = np.where(is_old, stated_charges[origin], 0)
            b_factors = None if b_factors is None else b_factors[origin]
        add_bonds(topology, perception.bonds, perception.bond_orders)
        charges = np.where(stated_charges != 0, stated_charges, perception.charges).astype(np.int32)
        derived = _derived(topology)
        if hydrogens_at_ph is not None:
            positions = turn_polar_hydrogens(
                derived["elements"],
                charges,
                derived["masses"],
                positions,
                perception.bonds,
                perception.bond_orders,
                ~is_old,
            )
        if perception.missing_atoms:
            count = sum(len(missing.names) for missing in perception.missing_atoms)
            notes = notes + [
                f"Heavy atoms are missing: {count}, in residues: {len(perception.missing_atoms)}."
            ]
        return cls(
            **derived,
            positions=positions,
            charges=charges,
            bonds=perception.bonds,
            bond_orders=perception.bond_orders,
            missing_atoms=perception.missing_atoms,
            notes=notes + perception.notes,
            source=source,
            source_hash=source_hash
            or _hash(positions, charges, perception.bonds, perception.bond_orders),
            box_vectors=box_vectors,
            b_factors=b_factors,
        )


def _derived(topology: Topology) -> dict[str, Any]:
    """Return what follows from the topology's atoms."""
    atoms = list(topology.atoms())
    labels: list[str] = []
    for residue in topology.residues():
        name = residue_label(residue)
        labels.extend(f"{atom.name} {name}" for atom in residue.atoms())
    return {
        "topology": topology,
        "elements": np.array([atom.element.atomic_number for atom in atoms], dtype=np.int32),
        "masses": np.array([atom.element.mass.value_in_unit(unit.dalton) for atom in atoms]),
        "labels": labels,
    }


def _hash(*arrays: NDArray[Any]) -> str:
    digest = hashlib.sha256()
    for array in arrays:
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()
