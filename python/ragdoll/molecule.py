"""A molecule as the rest of ragdoll sees it: atoms, bonds and their places."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from openmm import unit
from openmm.app import Topology
from rdkit import Chem

from .complexes import AtomTable, join_ligands
from .covalent_links import leaving_hydrogens
from .errors import InputError
from .hydrogens import add_hydrogens as place_hydrogens
from .ligands import Ligands
from .perception import Perception, perceive
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
        coordination: (K, 2) bonds of metals with other residues that the file records; they hold
            distances but no angles, and are not among ``bonds``.
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
    coordination: NDArray[np.int32] = field(
        default_factory=lambda: np.empty((0, 2), dtype=np.int32)
    )

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
        ligands: Sequence[str | Path | Chem.Mol] | str | Path | Chem.Mol = (),
        ligand_smiles: Mapping[str, str] | None = None,
        covalent_bonds: Sequence[str] | str = (),
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
            ligands: posed ligands, each an SDF, MOL or MOL2 file (``FILE:3`` and ``FILE:NAME`` say
                which record), or an RDKit molecule with a conformer. Each is a residue in a chain
                of its own, and takes the place of a residue that stands alone where it lies.
            ligand_smiles: a SMILES by the name of residues of the file that stand alone; it gives
                them bond orders, charges and hydrogens.
            covalent_bonds: between a ligand and a residue, each two addresses such as
                ``A:CYS145:SG=LIG:C12`` or two selections ``SEL1; SEL2``; those that the file
                records, or that are as short as a bond, are found without.

        Raises:
            InputError: the file, a ligand or an option cannot be used; the message says why.
        """
        wanted = Ligands.read(ligands, ligand_smiles, covalent_bonds)
        file = read_structure_file(path, model=model, altloc=altloc, chains=chains)
        keep, notes = atoms_to_keep(file.topology, keep_solvent, str(path))
        number = np.cumsum(keep) - 1
        recorded = file.recorded_bonds[keep[file.recorded_bonds].all(axis=1)]
        table = AtomTable(
            topology=copy_topology(file.topology, keep),
            positions=file.positions[keep],
            charges=file.charges[keep],
            recorded=number[recorded].reshape(-1, 2),
            hetero=file.hetero[keep],
            b_factors=file.b_factors[keep],
            notes=file.notes + notes,
        )
        if wanted:
            table = join_ligands(table, wanted, str(path), add_hydrogens)
        return cls._from_atoms(
            table,
            hydrogens_at_ph=ph if add_hydrogens else None,
            source=str(path),
            source_hash=file.source_hash,
            box_vectors=file.box_vectors if keep_solvent else None,
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
        table = AtomTable(
            topology=copy_topology(topology, keep),
            positions=places[keep],
            charges=np.array(stated, dtype=np.int32)[keep],
            recorded=np.empty((0, 2), dtype=np.int64),
            hetero=np.zeros(int(keep.sum()), dtype=bool),
            given=given,
            notes=notes,
        )
        return cls._from_atoms(
            table,
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

    def joined(
        self,
        ligands: Sequence[str | Path | Chem.Mol] | str | Path | Chem.Mol = (),
        *,
        ligand_smiles: Mapping[str, str] | None = None,
        covalent_bonds: Sequence[str] | str = (),
    ) -> "Molecule":
        """This molecule and its ligands as one; the arguments are those of ``from_file``.

        Bonds, charges and hydrogens of the molecule stay, but for hydrogens that leave for a bond
        to a ligand. Ligands get the hydrogens that they lack where the molecule has hydrogens.

        Raises:
            InputError: a ligand cannot be used, or does not fit.
        """
        wanted = Ligands.read(ligands, ligand_smiles, covalent_bonds)
        pairs = zip(self.bonds.tolist(), self.bond_orders.tolist(), strict=True)
        table = AtomTable(
            topology=self.topology,
            positions=self.positions,
            charges=self.charges,
            recorded=self.coordination.astype(np.int64),
            hetero=np.zeros(len(self), dtype=bool),
            b_factors=self.b_factors,
            given={(i, j): order for (i, j), order in pairs},
            settled=np.ones(len(self), dtype=bool),
            notes=list(self.notes),
        )
        made = Molecule._from_atoms(
            join_ligands(table, wanted, self.source or "The molecule", False),
            source=self.source,
            box_vectors=self.box_vectors,
        )
        return replace(made, missing_atoms=self.missing_atoms)

    @classmethod
    def _from_atoms(
        cls,
        table: AtomTable,
        *,
        source: str,
        source_hash: str = "",
        hydrogens_at_ph: float | None = None,
        box_vectors: NDArray[np.float64] | None = None,
    ) -> "Molecule":
        check_atoms(table.topology, table.positions, source)
        perception = _perceive(table)
        if hydrogens_at_ph is not None:
            table = _with_hydrogens(table, perception, hydrogens_at_ph)
            perception = _perceive(table)
        charges = _charges(table, perception)
        leaving = _leaving(table, perception, charges)
        if leaving:
            table = _without(table, leaving)
            perception = _perceive(table)
            charges = _charges(table, perception)
        topology, positions = table.topology, table.positions
        add_bonds(topology, perception.bonds, perception.bond_orders)
        derived = _derived(topology)
        if table.new is not None and (hydrogens_at_ph is not None or table.new.any()):
            positions = turn_polar_hydrogens(
                derived["elements"],
                charges,
                derived["masses"],
                positions,
                perception.bonds,
                perception.bond_orders,
                table.new,
            )
        notes = table.notes
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
            b_factors=table.b_factors,
            coordination=perception.coordination,
        )


def _closed(table: AtomTable) -> frozenset[int]:
    """Residues whose bonds, charges and hydrogens are known."""
    if table.settled is None:
        return frozenset()
    residues = (atom.residue.index for atom in table.topology.atoms() if table.settled[atom.index])
    return frozenset(residues)


def _perceive(table: AtomTable) -> Perception:
    positions = table.positions * _ANGSTROM
    return perceive(table.topology, positions, table.given, table.recorded, _closed(table))


def _charges(table: AtomTable, perception: Perception) -> NDArray[np.int32]:
    """Those that are stated, else those that were found; of ligands that are known, theirs."""
    charges = np.where(table.charges != 0, table.charges, perception.charges)
    if table.settled is not None:
        charges = np.where(table.settled, table.charges, charges)
    for i, j in [*table.links, *perception.links]:
        for end in (i, j):
            if charges[end] < 0:
                charges[end] = 0  # it has given its pair to the bond
    return charges.astype(np.int32)


def _with_hydrogens(table: AtomTable, perception: Perception, ph: float) -> AtomTable:
    """The atoms with the hydrogens that standard residues lack."""
    add_bonds(table.topology, perception.bonds, perception.bond_orders)
    topology, positions, origin, more = place_hydrogens(
        table.topology, table.positions, ph, _closed(table)
    )
    first = np.unique(origin, return_index=True)[1]
    is_old = np.zeros(len(origin), dtype=bool)
    is_old[first] = True
    new = ~is_old
    if table.new is not None:
        new |= table.new[origin]
    return AtomTable(
        topology=topology,
        positions=positions,
        charges=np.where(is_old, table.charges[origin], 0).astype(np.int32),
        recorded=first[table.recorded].reshape(-1, 2),
        hetero=table.hetero[origin],
        b_factors=None if table.b_factors is None else table.b_factors[origin],
        given={(int(first[i]), int(first[j])): order for (i, j), order in table.given.items()},
        settled=None if table.settled is None else table.settled[origin],
        new=new,
        links=[(int(first[i]), int(first[j])) for i, j in table.links],
        notes=table.notes + more,
    )


def _leaving(table: AtomTable, perception: Perception, charges: NDArray[np.int32]) -> list[int]:
    """Hydrogens that go for the bonds of ligands."""
    links = [*table.links, *perception.links]
    if not links:
        return []
    ends = [end for i, j in links for end in ((i, j), (j, i))]
    elements = [atom.element.atomic_number for atom in table.topology.atoms()]
    return leaving_hydrogens(
        ends, np.array(elements, dtype=np.int32), charges, table.positions, perception.bonds
    )


def _without(table: AtomTable, leaving: Sequence[int]) -> AtomTable:
    """The atoms without some of them."""
    keep = np.ones(len(table.positions), dtype=bool)
    keep[list(leaving)] = False
    number = np.cumsum(keep) - 1

    def kept(array):
        return None if array is None else array[keep]

    def renumbered(pair: tuple[int, int]) -> tuple[int, int]:
        return int(number[pair[0]]), int(number[pair[1]])

    atoms = list(table.topology.atoms())
    names = ", ".join(
        f"{atoms[index].name} of {residue_label(atoms[index].residue)}" for index in leaving
    )
    return AtomTable(
        topology=copy_topology(table.topology, keep),
        positions=table.positions[keep],
        charges=table.charges[keep],
        recorded=number[table.recorded[keep[table.recorded].all(axis=1)]].reshape(-1, 2),
        hetero=table.hetero[keep],
        b_factors=kept(table.b_factors),
        given={
            renumbered(pair): order for pair, order in table.given.items() if keep[list(pair)].all()
        },
        settled=kept(table.settled),
        new=kept(table.new),
        links=[renumbered(pair) for pair in table.links],
        notes=[*table.notes, f"For covalent bonds of ligands there left: {names}."],
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
